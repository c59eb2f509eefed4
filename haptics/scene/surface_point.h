#pragma once

// What queries of the parts find, in world coordinates.

#include <cstdint>

#include <glm/vec3.hpp>

#include "assets/base/ids.h"
#include "haptics/geometry/triangle_bvh.h"

namespace tandem::haptics {

/// First contact of the moving tool with any part, world frame.
struct WorldHit : BallHit {
  PartId part = kNoPart;
  std::uint32_t triangle = kNoTriangle;
};

/// A point of a part's surface, world frame.
struct SurfacePoint {
  PartId part = kNoPart;
  std::uint32_t triangle = kNoTriangle;
  glm::dvec3 point{0.0, 0.0, 0.0};
  glm::dvec3 normal{0.0, 0.0, 0.0};  // unit, towards the query point
  double distance = 0.0;             // m
  bool onFace = false;               // inside the triangle, neither on an edge nor a corner
};

}  // namespace tandem::haptics
