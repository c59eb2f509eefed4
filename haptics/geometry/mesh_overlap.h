#pragma once

// Whether two triangle meshes overlap, and how deep: hard clashes of an assembly. For reviews, never in a
// tick: it allocates.
//
// 1. Which side of a triangle is outside is not asked; open sheets have no inside: holds() of
// mesh_intrusion.h.
// 2. Safe in every thread: trees are only read.

#include "haptics/geometry/mesh_distance.h"

namespace tandem::haptics {

enum class Meeting : std::uint8_t {
  apart,      // no surface within the tolerance, nothing inside
  touching,   // as near as the tolerance, no deeper than it
  crossing,   // deeper, and surfaces meet
  contained,  // a shell of one is inside the other, no surfaces meet
};

/// See the head of this file. World frame.
struct MeshOverlap {
  Meeting meeting = Meeting::apart;
  double depth = 0.0;                 // m; see overlapOf()
  glm::dvec3 deepest{0.0, 0.0, 0.0};  // m, where it is found
  glm::dvec3 wayOut{0.0, 0.0, 0.0};   // m, from there to the nearest point of the other's surface
  bool inA = false;                   // `deepest` is a point of B inside A; else of A inside B
  bool sheets = false;                // nothing has an inside: `depth` is how far facets stand through others
};

/// Up to which depth an overlap is a touch, m: 2^-20 of the larger diagonal (a millionth), 2^-22 of the
/// largest coordinate in the meshes' frames (files hold floats) and what poses are rounded to. Flush faces of
/// one CAD assembly stay well below it; what tells them from a clash is this bound alone, at every scale.
double touchTolerance(const PlacedMesh& a, const PlacedMesh& b);

/// Depth: the largest distance from a point of either surface that is inside the other to the surface of that
/// other, sought as deepestInside() of mesh_intrusion.h says: never above the true one, and 1 % below it at
/// most unless the samples run out. Where surfaces lie on each other with both insides on one side (a part that
/// is there twice), no such point exists: then the radius of a ball inside both, below the middle of a facet.
/// Where neither surface has an inside: see MeshOverlap::sheets.
MeshOverlap overlapOf(const PlacedMesh& a, const PlacedMesh& b);

}  // namespace tandem::haptics
