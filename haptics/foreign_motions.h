#pragma once

// What other sites move in one tick as no hand moves it, and which hand meets it. A tick asks it what to give
// the ForeignGuard of each hand. Nothing allocates; a motion is looked up only for what a hand touches.

#include <array>
#include <span>

#include "haptics/base/tick_types.h"
#include "haptics/contact/part_contact.h"
#include "haptics/safety/foreign_guard.h"

namespace tandem::haptics {

class ForeignMotions {
 public:
  /// `moved` must outlive this.
  explicit ForeignMotions(std::span<const PartMotion> moved);

  /// The first hand's tool was followed by a part: by Tool::follow(), m.
  void noteTool(PartId part, double displacement);
  /// A pose was set under the first hand's tool.
  void notePut(const PartCommand& command);
  /// What is held may touch what is suspect. Null: nothing collides.
  void noteTouches(const PartContact* contact);

  /// A hand's tick, without its displacement; `out` has the contacts of the tool.
  ForeignGuard::Tick tickOf(int hand, const TickOutput& out, double stiffness) const;

 private:
  bool suspects(PartId part) const;

  std::span<const PartMotion> moved_;
  bool any_;                                             // of them is suspect
  std::array<double, kHands> displacement_{-1.0, -1.0};  // m; < 0: none
  bool held_ = false;                                    // what is held touches what is suspect
};

}  // namespace tandem::haptics
