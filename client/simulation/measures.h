#pragma once

// The measures of one hand that `tandem simulate` reports, by the definitions of its output.

#include <vector>

#include <glm/vec3.hpp>

#include "assets/base/pose.h"

namespace tandem::client {

struct HandSample {
  glm::dvec3 force{0.0, 0.0, 0.0};     // N, as the device applies it
  glm::dvec3 position{0.0, 0.0, 0.0};  // m, true device position
  double energyGiven = 0.0;            // J, to the hand, less what the scene's own sources gave
  bool pressing = false;               // the tool touches a fixed part
  bool still = false;                  // the person's target stands still
  bool brushes = false;                // the tool touches a movable part
  bool pushed = false;                 // the tool touches a movable part that moves
};

/// Collects one sample of a hand a tick, and computes the measures. A tick is 1 ms.
class HandMeasures {
 public:
  void add(const HandSample& sample);
  /// The hand's site gained or lost a part in this tick.
  void roleChanged() { roleChanges_.push_back(samples_.size()); }

  /// N/m: least-squares slope of force against travel while pressing, along the mean force; 0 if nothing was
  /// pressed.
  double feltStiffness() const;
  /// N: largest change of force within 20 ms.
  double forceStep() const;
  /// N: the largest such change in the 0.5 s after a role change, less the 99th percentile of those in the
  /// second before; 0 without a role change.
  double handoverExcess() const;
  double rmsForce() const;
  double maxForce() const;  // N
  bool pushed() const;      // at any time
  /// Whether nothing diverges, the position moves less than 0.5 mm peak to peak in the last 1.5 s if all
  /// targets stand still then, and the force never changes by more than 0.3 N in 20 ms while all hands stand
  /// still (`allStill`, one entry a sample).
  bool stable(const std::vector<bool>& allStill) const;
  /// Whether the bare tool left a movable part in the last tick. The part's co-holders feel that, later.
  bool slidOff() const;
  /// Whether nothing diverges, and the force never changes by more than 0.3 N in 20 ms while all hands stand
  /// still, no bare tool slides off a part (`undisturbed`, one entry a sample) and this bare tool touches no
  /// part that others may push.
  bool calm(const std::vector<bool>& undisturbed) const;
  const std::vector<HandSample>& samples() const { return samples_; }

 private:
  bool restsUnshaken(const std::vector<bool>& undisturbed, bool brushed) const;

  std::vector<HandSample> samples_;
  std::vector<double> forceChanges_;  // N, a sample each: the largest change within the 20 ms that end there
  std::vector<std::size_t> roleChanges_;
};

}  // namespace tandem::client
