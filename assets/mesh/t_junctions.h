#pragma once

// Joins vertices to the edges that they lie on. Where two faces were cut separately, a vertex of one lies on
// an edge of the other (a T-junction): no halfedge pairs there, and rounding leaves a crack of some units in
// the last place through which a point falls.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include <glm/vec3.hpp>

#include "assets/mesh/edge_pairs.h"

namespace tandem::assets {

/// A triangle that takes the place of another or of a part of it. Its corners have the other's attributes,
/// interpolated.
struct SplitTriangle {
  std::uint32_t parent = 0;             // index of the triangle that it is cut from
  TriangleIndices corners{};            // counter-clockwise as the parent
  std::array<glm::dvec3, 3> weights{};  // of the parent's corners, at each of its own
};

/// How the triangles have to be cut; `junctions` is 0 and `triangles` empty if not at all.
struct EdgeSplits {
  std::uint64_t junctions = 0;           // vertices joined to an edge; each makes one triangle more
  std::vector<SplitTriangle> triangles;  // all of them, in the order of their parents
};

/// Finds the vertices of open edges that lie within `tolerance` (m, Euclidean) of the inside of another open
/// edge which runs along one of theirs, and cuts the triangle of that edge there. Only open edges are
/// examined, so that a closed mesh costs nothing; vertices that merely touch an edge, faces that are folded
/// onto each other, and edges that have two faces stay as they are. No point is moved or made. What is cut
/// may again have open edges that overlap: call it until it finds none.
///
/// O(B log B) for B open edges that few vertices lie on. The work is limited to a multiple of B, past which
/// junctions stay. Deterministic, one thread.
EdgeSplits splitAtJunctions(const std::vector<glm::dvec3>& points,
                            const std::vector<TriangleIndices>& triangles, const EdgePairs& pairs,
                            double tolerance);

}  // namespace tandem::assets
