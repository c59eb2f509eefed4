#pragma once

#include "sync/wire/state_update.h"
#include "sync/wire/time.h"
// The display pose of a part that another site moves: the newest state extrapolated to the present by its
// velocity and acceleration, with corrections blended in. The prediction may be wrong, so no force may be
// coupled to it.
//
// No allocation. Times are session time.

namespace tandem::sync {

class PosePrediction {
 public:
  /// Draws the part at this pose from now on, at rest until the first state.
  void restart(const Pose& worldFromPart, Micros now);
  /// A state that held at `time`. A state older than the newest changes nothing.
  void push(const PartState& state, Micros time);
  /// Puts the part at rest at this pose, even if a state with a later time is known, whose clock was ahead.
  void standAt(const Pose& worldFromPart, Micros now);
  /// What to draw at session time `now`, which does not go backwards.
  Pose at(Micros now);

  /// Whether a step between the two poses is too small to be seen.
  static bool near(const Pose& a, const Pose& b);

  static constexpr Micros kFarthest = 300 * kMillisecond;  // longest extrapolation

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
