#pragma once

// What a scripted person writes in the session's document, or does for the others to see. The hand counts, in
// its own thread, the steps of its script that it has come to; the writer makes wishes of them, from what the
// model shows then, and hands on those that the others see.
//
// 1. Measures and clashes are found when their steps come, of the parts as they stand then. A measure takes
//    some milliseconds, all clashes of an engine a second.
// 2. Steps become wishes in their order. One that answers a note or a clash which is not there, perhaps
//    because the server has not answered yet, waits for kPatience, then it is passed over and a reason is
//    given.
//
// Main thread.

#include <deque>
#include <string>
#include <vector>

#include "client/hand/hand_script.h"
#include "client/session/view_model.h"

namespace tandem::client {

class ScriptWriter {
 public:
  /// `contact`, the scene's geometry, must outlive this.
  ScriptWriter(const HandScript& script, const haptics::ContactScene& contact);

  struct Written {
    std::vector<DocumentWish> wishes;
    std::vector<ScriptStep> shown;      // that the others see
    std::vector<std::string> problems;  // for a person
  };
  /// What is to be written at the time `now` in s, when the hand has come to the `begun`th of the steps that
  /// write. `camera` is what a `view` keeps.
  Written write(double now, std::uint32_t begun, const ViewModel& model, const Camera& camera);

  static constexpr double kPatience = 2.0;  // s

 private:
  void find(const ScriptStep& step, const ViewModel& model, Written& written) const;

  const haptics::ContactScene& contact_;
  std::deque<ScriptStep> steps_;  // that are not done yet
  std::uint32_t done_ = 0;
  double waitsSince_ = -1.0;  // s: the first step, for its note; negative: it does not wait
};

/// A note at the place that the hand touches, or on the named part at the place nearest to the hand; without
/// both where the hand is in the world.
document::Note noteAtHand(const ViewModel& model, PartId part, std::string text);

/// What an `inspect` step looks at, of the parts as they stand now.
sync::Inspection inspectByStep(const ScriptStep& step, const haptics::ContactScene& contact,
                               const ViewModel& model);

/// What a `measure` step asks for; an error if its places have no such figure.
Result<document::Measure> measureByStep(const ScriptStep& step, const haptics::ContactScene& contact,
                                        const ViewModel& model);

}  // namespace tandem::client
