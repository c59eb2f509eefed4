#pragma once

// Whether two triangle meshes overlap, and how deep: hard clashes of an assembly. For reviews, never in a
// tick: it allocates.
//
// 1. The orientation of triangles does not matter, and open sheets have no inside: containsPoint() of
//    mesh_intrusion.h.
// 2. Safe in every thread: the trees are only read.

#include "haptics/geometry/mesh_distance.h"

namespace tandem::haptics {

enum class Meeting : std::uint8_t {
  apart,      // no surface within the tolerance, nothing inside
  touching,   // surfaces within the tolerance, overlap no deeper than it
  crossing,   // deeper, and the surfaces meet
  contained,  // a shell of one is inside the other, the surfaces do not meet
};

/// Result of overlapOf(), world frame.
struct MeshOverlap {
  Meeting meeting = Meeting::apart;
  double depth = 0.0;                  // m; see overlapOf()
  glm::dvec3 deepest{0.0, 0.0, 0.0};   // m, where the depth occurs
  glm::dvec3 exitPath{0.0, 0.0, 0.0};  // m, from there to the nearest point of the other's surface
  bool inA = false;                    // `deepest` is a point of B inside A; else of A inside B
  bool sheets = false;  // no surface has an inside: `depth` is the length by which facets cross
};

/// Depth up to which an overlap counts as a touch, m: 2^-20 of the larger diagonal (a millionth), plus 2^-22
/// of the largest coordinate in the meshes' frames (files hold floats) and the rounding of the poses. Flush
/// faces of a CAD assembly stay well below it. This bound alone separates them from a clash, at every scale.
double touchTolerance(const PlacedMesh& a, const PlacedMesh& b);

/// Depth: the largest distance from a point of either surface that is inside the other to that other surface,
/// searched by deepestInside() of mesh_intrusion.h. It is never above the true depth, and at most 1 % below
/// it unless the samples run out. Where surfaces coincide with both insides on one side (a duplicated part),
/// no such point exists; the depth is then the radius of a ball inside both, below the centre of a facet.
/// Where neither surface has an inside, see MeshOverlap::sheets.
MeshOverlap overlapOf(const PlacedMesh& a, const PlacedMesh& b);

}  // namespace tandem::haptics
