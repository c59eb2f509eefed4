#pragma once

// A contact force that others have brought onto the hand, let in little by little.

#include <glm/vec3.hpp>

namespace tandem::haptics {

/// Where sections move, a force that ends may fade at up to kGentleFade N/s and one that arrives grow at up
/// to kGentleArrival: 0.28 N in 20 ms together.
inline constexpr double kGentleFade = 9.0, kGentleArrival = 5.0;

/// Holds back the part of a contact force that has arrived at once. What is held back shrinks with time, and
/// with the contact force itself: it never pulls towards a surface.
class Arrival {
 public:
  /// From now on `force` (N) is held back, in place of what was.
  void start(const glm::dvec3& force) { held_ = force; }

  /// N, what is held back now of a contact force; in a later tick `step` N less.
  glm::dvec3 heldBack(const glm::dvec3& force, double step);

 private:
  glm::dvec3 held_{0.0, 0.0, 0.0};
};

}  // namespace tandem::haptics
