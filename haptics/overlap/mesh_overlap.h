#pragma once

// Whether two triangle meshes overlap, and how deep: hard clashes of an assembly. For reviews, never in a
// tick: it allocates.
//
// 1. The answer does not depend on the frames in which the meshes are given, but for rounding.
// 2. The orientation of shells does not matter, open sheets have no inside, and what an open shell leaves
//    open is said: mesh_closing.h.
// 3. Safe in every thread: trees and closings are only read.

#include "haptics/geometry/mesh_distance.h"
#include "haptics/overlap/mesh_closing.h"

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
  glm::dvec3 deepest{0.0, 0.0, 0.0};   // m, where the depth occurs: on one surface, in or on the other part
  glm::dvec3 exitPath{0.0, 0.0, 0.0};  // m, from there to the nearest point of the other's surface
  bool inA = false;                    // `deepest` is a point of B inside A; else of A inside B
  /// The depth cannot be known because a shell is open: `depth` is then what it is at least, 0 where nothing
  /// is certainly inside.
  bool open = false;
  bool sheets = false;  // no surface has an inside: `depth` is the length by which facets cross; open too
};

/// Depth up to which an overlap counts as a touch, m: 2^-20 of the larger diagonal (a millionth), plus 2^-22
/// of the largest coordinate in the meshes' frames (files hold floats) and the rounding of the poses. Flush
/// faces of a CAD assembly stay well below it. This bound alone separates them from a clash, at every scale.
double touchTolerance(const PlacedMesh& a, const PlacedMesh& b);

/// Depth: the largest distance from a point of either surface that is inside the other to that other
/// surface, the one-sided Hausdorff distance of what overlaps (Tang, Lee & Kim 2009, "Interactive Hausdorff
/// distance computation for general polygonal models", which measures penetration so). It is found within
/// 2^-23 of the smaller diagonal by findDeepest() of mesh_intrusion.h.
///
/// Inside is meant with lids over the holes of a part (mesh_closing.h). The depth is known if it is the
/// same, within the tolerance, whether or not lids count as surface, at a point that is inside for certain;
/// else `open` is set. Where surfaces coincide with both insides on one side (a duplicated part), no point
/// of one is inside the other; the depth is then the radius of the largest ball inside both that touches
/// the centre of a facet, and known if that ball is no larger where lids do not count as surface. Where
/// surfaces cross and neither has an inside, see MeshOverlap::sheets.
MeshOverlap overlapOf(const PlacedMesh& a, const MeshClosing& closedA, const PlacedMesh& b,
                      const MeshClosing& closedB);

/// The same for meshes that are measured once.
MeshOverlap overlapOf(const PlacedMesh& a, const PlacedMesh& b);

}  // namespace tandem::haptics
