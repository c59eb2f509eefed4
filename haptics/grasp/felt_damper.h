#pragma once

// The damping force of a virtual coupling, as the hand feels it while the part that it holds is in contact. A
// part that contact stops or releases changes its velocity within one tick, and so would the damping force: a
// kick of 0.4 N where a hand meets a wall at 100 mm/s. So the part is always given the whole damping force.
// In contact the hand is given only a small part of it, which comes and goes gradually, beside the whole
// force of the spring.
//
// This is passive. With the damping B, the velocities x of the hand and y of the grip on the part, and the
// damping force f on the hand, hand and part together gain the power
//     f . x - B (y - x) . y
// For the whole damping force, f = B (y - x), it is -B |y - x|^2. Where a smaller force would make it
// positive, the force is moved towards the whole one until the power is zero.

#include <glm/vec3.hpp>

namespace tandem::haptics {

class FeltDamper {
 public:
  /// The damping force on the hand in this tick, N, world. `damping` in N·s/m; `grip` and `hand` are the
  /// velocities of the grip and of the hand in the tick, m/s, world; `touches`: the part is in contact.
  /// In contact the force is at most `change` N. From one tick to the next it changes by at most `change` N,
  /// also after contact, until it has become the whole damping force again. It exceeds both limits where it
  /// would else not be passive. A `change` of 0 sets no limit. To be called once a tick.
  const glm::dvec3& force(double damping, const glm::dvec3& grip, const glm::dvec3& hand, bool touches,
                          double change);
  /// N, of the last tick.
  const glm::dvec3& last() const { return felt_; }

 private:
  glm::dvec3 felt_{0.0, 0.0, 0.0};  // N, last()
  bool whole_ = true;               // it was the whole damping force
};

}  // namespace tandem::haptics
