#pragma once

// How far a straight piece is from a field's surface.

#include <algorithm>

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include "haptics/scene/distance_field.h"

namespace tandem::haptics {

/// m, a lower bound for all places between `place`, where the field reads `here`, and `place + along`.
/// Between the two a concave distance is least at an end, and a convex one lies above the tangents at both.
/// Where the error at the other end is above `rough` (m), a distance counts that falls as the way is long.
inline float leastTowards(const DistanceField& field, const glm::vec3& place,
                          const DistanceField::Reading& here, const glm::vec3& along, float rough) {
  const DistanceField::Reading there = field.read(place + along);
  const float a = here.distance - here.error, b = there.distance - there.error,
              down = -glm::dot(here.gradient, along), up = glm::dot(there.gradient, along);
  if (there.error > rough) return 0.5f * (a + b - glm::length(along));
  const float valley = down > 0.0f && up > 0.0f ? (up * a + down * b - down * up) / (down + up) : b;
  return std::min({a, b, valley});
}

/// The same for all places at most `along` on either side of `place`.
inline float leastAlong(const DistanceField& field, const glm::vec3& place,
                        const DistanceField::Reading& here, const glm::vec3& along, float rough) {
  return std::min(leastTowards(field, place, here, along, rough),
                  leastTowards(field, place, here, -along, rough));
}

}  // namespace tandem::haptics
