#pragma once

// The largest value that the least of a few linear functions takes on a triangle: an upper bound of a
// distance to several convex things.

#include <span>

#include <glm/vec3.hpp>

namespace tandem::haptics {

/// A place on a triangle.
struct Peak {
  double value = 0.0;
  glm::dvec3 shares{1.0, 0.0, 0.0};  // of the three corners, summing to 1
};

/// Each function is given by its values at the three corners; at least one, at most kMaxFunctions. A
/// linear program in the two free shares, solved by trying its vertices: corners, points of sides where two
/// functions are equal, and points where three are.
Peak peakOfLeast(std::span<const glm::dvec3> functions);
inline constexpr std::size_t kMaxFunctions = 5;

}  // namespace tandem::haptics
