#include "sync/wire/wire_frame.h"

#include <algorithm>
#include <cmath>

namespace tandem::sync {

WireFrame wireFrame(const assets::Bounds& sceneBounds) {
  const glm::dvec3 size = sceneBounds.max - sceneBounds.min;
  const double largest = std::max({size.x, size.y, size.z});
  if (!(size.x >= 0.0 && size.y >= 0.0 && size.z >= 0.0) || !(largest < 1e6)) return {};
  WireFrame frame;
  frame.centre = 0.5 * (sceneBounds.min + sceneBounds.max);
  // The cube is eight times as long as the scene, and at least 1 m, because hands move in metres even where
  // parts are small.
  const double wanted = std::max(4.0 * largest, 0.5);
  frame.halfExtent = std::exp2(std::ceil(std::log2(wanted)));
  return frame;
}

bool contains(const WireFrame& frame, const glm::dvec3& worldPoint) {
  const glm::dvec3 away = glm::abs(worldPoint - frame.centre);
  return away.x <= frame.halfExtent && away.y <= frame.halfExtent && away.z <= frame.halfExtent;
}

}  // namespace tandem::sync
