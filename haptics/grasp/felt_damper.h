#pragma once

// What a hand feels of the damper between it and a part that touches others. A part that contact stops or
// lets go changes its speed within a tick, and so would the damper's force: a kick of 0.4 N where a hand
// meets a wall at 100 mm/s. So the part is given the whole of the damper's force, and the hand a force that
// is small while the part touches, and comes and goes gradually: what it feels then is the spring.
//
// This can only dissipate energy. With the damping B, the velocities x of the hand and y of the grip, and the
// force f on the hand, hand and part together gain the power
//     f . x - B (y - x) . y
// which is -B |y - x|^2 for the whole force, f = B (y - x). Where a lesser f would gain something, the hand
// is given as much more of the whole as it takes to gain nothing.

#include <glm/vec3.hpp>

namespace tandem::haptics {

class FeltDamper {
 public:
  /// N, what the hand feels of a damper (N·s/m) between the grip on a part and the hand, which moved with
  /// these velocities (m/s, world) in this tick. It is at most `change` (N, >= 0; 0 = any) while the part
  /// `touches` others, and so are its changes from tick to tick until the whole is felt again; both unless
  /// energy would be gained. Call it once a tick.
  const glm::dvec3& force(double damping, const glm::dvec3& grip, const glm::dvec3& hand, bool touches,
                          double change);
  /// N, of the last tick.
  const glm::dvec3& last() const { return felt_; }

 private:
  glm::dvec3 felt_{0.0, 0.0, 0.0};  // N
  bool whole_ = true;               // the hand felt all of it
};

}  // namespace tandem::haptics
