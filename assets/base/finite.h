#pragma once

// Separate from pose.h, so that not every source with a pose includes <cmath>.

#include <cmath>

#include <glm/vec3.hpp>

namespace tandem {

/// Whether no coordinate is infinite or not a number.
inline bool isFinite(const glm::dvec3& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

}  // namespace tandem
