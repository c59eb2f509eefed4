#pragma once

// Directions across a given one.

#include <cmath>
#include <utility>

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

namespace tandem {

/// Two unit vectors u and v at right angles to the unit vector `normal` and to each other, v = normal x u.
inline std::pair<glm::dvec3, glm::dvec3> acrossOf(const glm::dvec3& normal) {
  const glm::dvec3 other = std::abs(normal.x) < 0.7 ? glm::dvec3(1.0, 0.0, 0.0) : glm::dvec3(0.0, 1.0, 0.0);
  const glm::dvec3 u = glm::normalize(glm::cross(normal, other));
  return {u, glm::cross(normal, u)};
}

}  // namespace tandem
