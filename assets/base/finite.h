#pragma once

// Kept apart from pose.h, so that <cmath> is not in every file that names a pose.

#include <cmath>

#include <glm/vec3.hpp>

namespace tandem {

/// Whether no coordinate is infinite or not a number.
inline bool isFinite(const glm::dvec3& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

}  // namespace tandem
