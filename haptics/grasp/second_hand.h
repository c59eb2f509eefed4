#pragma once

// A tick's second hand: its readings, what ends in its grasp, and what leaves for its device.
//
// Both hands draw at the parts of one HeldParts, so that they meet there and nowhere else: each has a guard of its
// readings, fades and limits of its own. Nothing here allocates.

#include "haptics/base/fault.h"
#include "haptics/base/tick_types.h"
#include "haptics/body/fade.h"
#include "haptics/grasp/held_part.h"
#include "haptics/safety/output_limits.h"
#include "haptics/safety/resting_reading.h"
#include "haptics/safety/sample_guard.h"

namespace tandem::haptics {

class SecondHandPort {
 public:
  /// Begins a tick: judges the reading. A hand that is somewhere else holds its part where it now is.
  void note(const SecondHand& hand, const TickParameters& ofFirst, HeldParts& parts, FaultLatch& fault);

  /// Takes an owned part where both are; false without a reading so far, and as HeldParts::grasp().
  bool grasp(PartId part, HeldParts& parts);
  /// Lets go of what it holds, if anything; what it felt fades.
  void letGo(HeldParts& parts);

  /// What draws at its part in this tick.
  HandPull pull() const;

  /// Ends a tick: what the coupling's wrench on the hand becomes on its device.
  SecondHandOutput send(const Wrench& coupling, const HeldParts& parts, FaultLatch& fault);

 private:
  SampleGuard guard_;
  RestingReading reading_;
  Fade fade_;
  OutputLimits limits_;
  TickParameters parameters_;         // of this tick
  DeviceSample device_, felt_;        // the last valid reading; without the flicker of a hand at rest
  Wrench coupling_;                   // of the last tick, before limits
  Wrench tool_, lastTool_;            // what its bare tool feels in this tick and in the last
  glm::dvec3 move_{0.0}, turn_{0.0};  // m and rad, that the hand went since the last tick
  double invalidTime_ = 0.0;          // s since the last valid reading
  bool valid_ = false, started_ = false;
  std::uint32_t flags_ = 0;
};

}  // namespace tandem::haptics
