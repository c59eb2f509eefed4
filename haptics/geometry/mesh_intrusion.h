#pragma once

// Search for the deepest point of one mesh inside another, used by mesh_overlap.

#include <cstdint>
#include <vector>

#include "assets/base/pose.h"
#include "haptics/geometry/triangle_bvh.h"

namespace tandem::haptics {

/// The deepest point found, in the frame of the mesh that contains it.
struct Deepest {
  double depth = 0.0;                  // m, its distance to that mesh's surface
  glm::dvec3 point{0.0, 0.0, 0.0};     // m
  glm::dvec3 exitPath{0.0, 0.0, 0.0};  // m, from the point to the nearest point of the surface
  bool found = false;
};

/// A crossing of a mesh edge with the surface of the other mesh.
struct EdgeCut {
  std::uint32_t from, to;  // vertices, from < to
  double share;            // fraction of the edge
};

/// The deepest point of one mesh inside the other, `solid`. `touched` are all triangles of the mesh within
/// `tolerance` (m) of the solid's surface, `cuts` the crossings of their edges with it. The search tests
/// corners and the centres of touched faces, then halves edges and faces that promise 1 % more than the best,
/// most promising first; the depth of a point changes by at most a metre per metre. It halves at most
/// kMaxSamples edges and as many faces, and only kFewSamples of each while nothing is deeper than the
/// tolerance, unless `cross` says that the surfaces cross each other.
Deepest deepestInside(const TriangleBvh& mesh, const TriangleBvh& solid, const Pose& solidFromMesh,
                      const std::vector<std::uint32_t>& touched, std::vector<EdgeCut> cuts, double tolerance,
                      bool cross);
inline constexpr int kMaxSamples = 1000, kFewSamples = 64;

/// Whether p (mesh frame) is inside: five of six rays count a winding number other than 0, so that inverted
/// shells are solid too. Open sheets have no inside.
bool containsPoint(const TriangleBvh& tree, const glm::dvec3& p);

}  // namespace tandem::haptics
