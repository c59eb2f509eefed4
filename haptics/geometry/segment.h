#pragma once

// Relations between a point and a line segment.

#include <algorithm>

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

namespace tandem::haptics {

/// The point of the segment a-b nearest to p; a and b may coincide.
inline glm::dvec3 closestPointOnSegment(const glm::dvec3& p, const glm::dvec3& a, const glm::dvec3& b) {
  const glm::dvec3 ab = b - a;
  const double square = glm::dot(ab, ab);
  return square > 0.0 ? a + ab * std::clamp(glm::dot(p - a, ab) / square, 0.0, 1.0) : a;
}

}  // namespace tandem::haptics
