#pragma once

// Axis-aligned boxes.

#include <glm/common.hpp>
#include <glm/vec3.hpp>

namespace tandem::assets {

/// Axis-aligned box, m. Empty while min > max.
struct Bounds {
  glm::dvec3 min{1e300, 1e300, 1e300};
  glm::dvec3 max{-1e300, -1e300, -1e300};

  void include(const glm::dvec3& point) {
    min = glm::min(min, point);
    max = glm::max(max, point);
  }
  void include(const Bounds& other) {
    min = glm::min(min, other.min);
    max = glm::max(max, other.max);
  }
};

}  // namespace tandem::assets
