#pragma once

// Energy at a device's port, as an observer sees it.

#include <glm/vec3.hpp>

#include "assets/base/pose.h"

namespace tandem::haptics {

/// Passivity observer of Hannaford & Ryu 2002, "Time-domain passivity control of haptic interfaces": sums
/// force times velocity, tick by tick. A passive system never returns more energy than it received.
class EnergyObserver {
 public:
  /// `force` (N) acts on the hand, constant over the tick; `velocity` (m/s) the hand's in that
  /// tick.
  void add(const glm::dvec3& force, const glm::dvec3& velocity, double dt);
  void add(const Wrench& toHand, const Twist& hand, double dt);
  /// The same from the hand's displacement (m) while the force was held: exact, whatever the velocity did.
  void addWork(const glm::dvec3& force, const glm::dvec3& displacement);

  /// Energy given to the hand so far, J; negative while the hand gave more.
  double given() const { return given_; }
  /// Largest excess of energy given to the hand over energy received from it since the start, J, >= 0.
  double mostCreated() const { return mostCreated_; }
  void reset() { *this = EnergyObserver{}; }

 private:
  double given_ = 0.0;
  double mostCreated_ = 0.0;
};

}  // namespace tandem::haptics
