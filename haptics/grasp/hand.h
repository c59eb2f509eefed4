#pragma once

// One hand of a tick: its readings, the forces that end on it, and what leaves for its device.
//
// 1. All hands pull at the parts of one HeldParts, so that they meet there and nowhere else.
// 2. A tick calls begin() first and send() last.
// 3. Only the thread that ticks uses it. Nothing here allocates.

#include <algorithm>
#include <cstdint>

#include "haptics/base/fault.h"
#include "haptics/base/tick_types.h"
#include "haptics/body/arrival.h"
#include "haptics/body/fade.h"
#include "haptics/grasp/held_part.h"
#include "haptics/safety/output_limits.h"
#include "haptics/safety/resting_reading.h"
#include "haptics/safety/sample_guard.h"

namespace tandem::haptics {

class Hand {
 public:
  /// `hasTool`: the hand's bare tool is part of the same tick. Only then is a force that ends clipped to
  /// the limits of the device, and only then does it fade with the displacement of the very tick in which
  /// it ends.
  explicit Hand(bool hasTool) : hasTool_(hasTool) {}

  /// Begins a tick: judges the reading. `parameters` are the hand's.
  void begin(const HandInput& input, const TickParameters& parameters);
  /// The ticks have stood still: a hand that the next valid reading shows elsewhere did not move there in
  /// contact.
  void noteStall() { stalled_ = true; }

  /// Whether this tick has a valid reading.
  bool valid() const { return valid_; }
  /// Whether there has been a valid reading.
  bool started() const { return started_; }
  /// Whether the hand is in another place that it did not reach by moving there.
  bool elsewhere() const { return elsewhere_; }
  /// s without a valid reading before this tick.
  double silence() const { return silence_; }
  const TickParameters& parameters() const { return parameters_; }
  /// The last valid reading.
  const DeviceSample& device() const { return device_; }
  /// The last valid reading without the flicker of an encoder's quantum, which looks like a velocity of a
  /// hand at rest: no damper may follow it.
  const DeviceSample& steadyDevice() const { return steadyDevice_; }
  /// m, of the hand since the last tick.
  const glm::dvec3& displacement() const { return displacement_; }
  /// The same, also of a hand whose tool is not part of the tick.
  const glm::dvec3& motion() const { return motion_; }

  /// What pulls at the part in the hand.
  HandPull pull() const {
    return {valid_ ? &steadyDevice_ : nullptr, HandPull::gainsOf(parameters_), parameters_.forceLimit,
            parameters_.torqueLimit, way_};
  }
  /// Notes the wrench of the hand's coupling in this tick, before limits.
  void setCoupling(const Wrench& coupling) { coupling_ = valid_ ? coupling : Wrench{}; }

  /// A wrench that ends fades from this tick on, as that of a spring.
  void fadeOut(const Wrench& ended, const Fade::Stiffness& stiffness);
  /// The coupling ends; its wrench fades as that of a spring of `springs` times its stiffness.
  void endCoupling(double springs);
  /// The hand takes a part: the wrench of its bare tool in the last tick fades from now on.
  void endTool() { fadeOut(lastTool_, {parameters_.stiffness, 0.0}); }
  Fade& fade() { return fade_; }
  /// Sections have made of the tool's contact force `last` (N) the force `now`: what has ended of it fades,
  /// and what has come is let in slowly, so that the hand first gets what it got. `spring`: N/m, of the
  /// contacts.
  void bridge(const glm::dvec3& last, const glm::dvec3& now, double spring);
  /// What is let in of the tool's contact force now, N; once a tick.
  glm::dvec3 letIn(const glm::dvec3& contact) {
    return contact - arrival_.heldBack(contact, kGentleArrival * parameters_.dt);
  }

  /// Ends a tick: what the wrenches of coupling and fade, and that of what the tool `touches` if not null,
  /// become on the device. `cause` explains the change of the sum. Adds to flags().
  Wrench send(const Wrench* touches, const ForceCause& cause, FaultLatch& fault);
  /// No wrench was sent in this tick: the next one grows from zero.
  void sendNothing() {
    limits_ = OutputLimits{};
    sentShare_ = 0.0;
  }
  /// What the bare tool feels in a tick of its own, if it counts now: the hand is read, and `holds` nothing.
  const Wrench* tool(bool holds) const { return valid_ && !holds ? &tool_ : nullptr; }
  /// How much of the wanted force the limits let through in the last send(), 0..1, along it: what fields do
  /// to the hand, they do in this proportion.
  double sentShare() const { return sentShare_; }
  /// The same before the gain, 0..1.
  double passedShare() const {
    return parameters_.gain > 0.0 ? std::min(1.0, sentShare_ / parameters_.gain) : 0.0;
  }
  /// TickFlags of this tick's reading and limits.
  std::uint32_t flags() const { return flags_; }

 private:
  Wrench withinLimits(const Wrench& wrench) const;
  double shareOf(const glm::dvec3& wanted) const;

  bool hasTool_;
  SampleGuard guard_;
  RestingReading reading_;
  Fade fade_;
  Arrival arrival_;
  OutputLimits limits_;
  TickParameters parameters_;  // of this tick
  DeviceSample device_, steadyDevice_;
  Wrench coupling_;                               // of the last tick, before limits
  Wrench tool_, lastTool_;                        // HandInput::tool of this tick and of the last
  glm::dvec3 displacement_{0.0}, rotation_{0.0};  // m and rad, what fades follows
  glm::dvec3 motion_{0.0};                        // m, of the hand since the last tick
  double way_ = 0.0;                          // m, of the hand in the fastest of the last ticks; it decays
  double invalidTime_ = 0.0, silence_ = 0.0;  // s since the last valid reading: now, and before this tick
  double sentShare_ = 0.0;
  bool valid_ = false, started_ = false, elsewhere_ = false, stalled_ = false;
  std::uint32_t flags_ = 0;
};

}  // namespace tandem::haptics
