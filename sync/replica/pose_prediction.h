#pragma once

// Where a part that another site moves is by now, for the eyes: the newest state carried on by its velocity and
// acceleration to the present, corrections blended in. What it says may be wrong, so nothing may be coupled to it.
//
// No allocation. Times are session time.

#include "sync/wire/messages.h"

namespace tandem::sync {

class PosePrediction {
 public:
  /// From now on the part is drawn from this pose on, at rest until there is a state.
  void restart(const Pose& worldFromPart, Micros now);
  /// A state that held at `time`; older ones than the newest change nothing.
  void push(const PartState& state, Micros time);
  /// The part stands there, whatever states of a clock that is ahead have said.
  void standAt(const Pose& worldFromPart, Micros now);
  /// What to draw at session time `now`, which does not go backwards.
  Pose at(Micros now);

  /// Nobody sees a step between these two.
  static bool near(const Pose& a, const Pose& b);

  static constexpr Micros kFarthest = 300 * kMillisecond;  // carried on no further than that

 private:
  Pose carriedOn(Micros now) const;

  bool known_ = false, drawnBefore_ = false;
  double usualAge_us_ = 0.0;  // of the newest state when it comes
  PartState newest_;
  Micros time_ = 0, drawnAt_ = 0;
  glm::dvec3 acceleration_{0.0, 0.0, 0.0};                       // m/s^2, low-passed
  Pose drawn_;                                                   // of the last at()
  glm::dvec3 offset_{0.0, 0.0, 0.0}, turnedOff_{0.0, 0.0, 0.0};  // m, rad: still to be blended away
};

}  // namespace tandem::sync
