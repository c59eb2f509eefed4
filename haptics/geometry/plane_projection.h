#pragma once

// The god-object projection inside the proxy: the point nearest to a goal that satisfies a few planes.

#include <array>
#include <span>

#include <glm/vec3.hpp>

namespace tandem::haptics {

/// The half space normal . x >= offset; normal is a unit vector.
struct HalfSpace {
  glm::dvec3 normal{0.0, 0.0, 0.0};
  double offset = 0.0;
};

inline constexpr int kMaxPlanes = 8;

/// x = goal + sum of multiplier[i] * normal[i], with at most three multipliers that are not zero.
struct Projection {
  glm::dvec3 point{0.0, 0.0, 0.0};
  std::array<double, kMaxPlanes> multiplier{};  // m, >= 0
  bool exact =
      true;  // false: no point satisfies all planes within the tolerance; `point` violates them least
};

/// God-object projection: minimises |x - goal|^2 subject to all planes (at most kMaxPlanes), the constraint
/// problem of the god object (Zilles & Salisbury 1995, there with Lagrange multipliers). Tries every set of
/// up to three active planes: the Karush-Kuhn-Tucker conditions of this strictly convex problem have exactly
/// one solution, whatever the order of the planes. `tolerance` (m) is the violation that rounding may cause.
Projection projectOntoPlanes(const glm::dvec3& goal, std::span<const HalfSpace> planes, double tolerance);

}  // namespace tandem::haptics
