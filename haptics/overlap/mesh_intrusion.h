#pragma once

// Search for the deepest point of one mesh inside another, used by mesh_overlap.

#include <cstdint>
#include <vector>

#include "assets/base/pose.h"
#include "haptics/overlap/mesh_closing.h"

namespace tandem::haptics {

/// The deepest point found, in the frame of the mesh that contains it.
struct Deepest {
  double depth = 0.0;                  // m, its distance to that mesh's surface
  glm::dvec3 point{0.0, 0.0, 0.0};     // m
  glm::dvec3 exitPath{0.0, 0.0, 0.0};  // m, from the point to the nearest point of the surface
  bool found = false;
};

/// A triangle of the mesh and one of the solid, or of its lids, that are within the tolerance of each other.
struct NearTriangles {
  std::uint32_t own = 0, other = 0;
  bool lid = false;      // `other` is one of the lids
  bool crosses = false;  // they stand through each other by more than rounding
};

/// A mesh in a solid, and where they are near each other.
struct Intrusion {
  const TriangleBvh& mesh;
  const MeshClosing& solid;
  Pose solidFromMesh;
  std::vector<NearTriangles> near;  // all pairs within the tolerance, lids included
  double tolerance = 0.0;           // m, depths up to it do not matter
  double precision = 0.0;           // m, by which the depth found may be too small
};

/// Replaces `best` by the deepest point of the mesh inside the solid if it is deeper. The points are those
/// that are inside for certain (MeshClosing::isCertain), their depth the distance to the solid's surface
/// and to its lids.
///
/// Branch and bound on the triangles of the mesh. A triangle is first cut along the lines where the solid's
/// surface crosses it, so that each piece is on one side. The distance to a facet is a convex function and
/// lies under the plane through its values at a piece's corners, so the peak of the least of such planes
/// bounds the depth of the piece (peak_of_least.h). The most promising piece is measured at that peak, then
/// halved, until no piece promises more than the precision, or kMaxSamples pieces were measured.
///
/// Returns whether the solid's lids had a part in it; else anyDeeperWithoutLids() is false for that depth.
bool findDeepest(const Intrusion& intrusion, Deepest& best);
inline constexpr int kMaxSamples = 1 << 15;
/// In tolerances of touch: a lid that is nearer than the surface by less than this closes a slit, and does
/// not count.
inline constexpr double kSlit = 0x1p-4;

/// Whether a point of the mesh inside mesh and lids of the solid, certain or not, is farther than `depth`
/// from the solid's surface alone: then the depth depends on what the solid lacks.
bool anyDeeperWithoutLids(const Intrusion& intrusion, double depth);

/// Whether p (mesh frame) is inside: five of six rays count a winding number other than 0, so that inverted
/// shells are solid too. Open sheets have no inside. Beside holes the answer depends on the frame.
bool containsPoint(const TriangleBvh& tree, const glm::dvec3& p);

}  // namespace tandem::haptics
