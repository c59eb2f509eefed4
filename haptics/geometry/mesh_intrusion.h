#pragma once

// The deepest point of one mesh inside another. The search behind mesh_overlap.

#include <cstdint>
#include <vector>

#include "assets/base/pose.h"
#include "haptics/geometry/triangle_bvh.h"

namespace tandem::haptics {

/// The deepest point found. Frame of the mesh that it is inside of.
struct Deepest {
  double depth = 0.0;               // m, its distance to that mesh's surface
  glm::dvec3 point{0.0, 0.0, 0.0};  // m
  glm::dvec3 way{0.0, 0.0, 0.0};    // m, from there to the nearest point of the surface
  bool found = false;
};

/// Where an edge of a mesh goes through the surface of the other.
struct EdgeCut {
  std::uint32_t from, to;  // vertices, from < to
  double share;            // of the edge
};

/// One mesh seen by the other, `solid`. `touched`: all triangles of the mesh within `tolerance` (m) of the
/// solid's surface; `cuts`: where their edges go through it. Tried are corners and the middles of touched
/// faces, then edges and faces are cut in halves where they promise 1 % more than the best, the most promising
/// first: the depth of a point changes by at most a metre a metre. At most kMostSamples halvings of edges, and
/// as many of faces; only kFewSamples each while nothing is deeper than the tolerance, unless `cross` says that
/// surfaces go through each other.
Deepest deepestInside(const TriangleBvh& mesh, const TriangleBvh& solid, const Pose& solidFromMesh,
                      const std::vector<std::uint32_t>& touched, std::vector<EdgeCut> cuts, double tolerance,
                      bool cross);
inline constexpr int kMostSamples = 1000, kFewSamples = 64;

/// Whether p (mesh frame) is inside: five of six rays count a winding number other than 0, so that shells
/// turned inside out are solid too. Open sheets have no inside.
bool holds(const TriangleBvh& tree, const glm::dvec3& p);

}  // namespace tandem::haptics
