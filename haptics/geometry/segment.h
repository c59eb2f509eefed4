#pragma once

// A point and a piece of a straight line.

#include <algorithm>

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

namespace tandem::haptics {

/// The point between a and b that is nearest to p. Both may be the same.
inline glm::dvec3 closestPointOnSegment(const glm::dvec3& p, const glm::dvec3& a, const glm::dvec3& b) {
  const glm::dvec3 ab = b - a;
  const double square = glm::dot(ab, ab);
  return square > 0.0 ? a + ab * std::clamp(glm::dot(p - a, ab) / square, 0.0, 1.0) : a;
}

}  // namespace tandem::haptics
