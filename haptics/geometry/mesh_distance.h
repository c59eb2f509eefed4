#pragma once

// Exact least distance between the surfaces of two triangle meshes, with the points and triangles where it
// occurs. For reviews of an assembly, never in a tick: it allocates.
//
// Safe in every thread: the trees are only read.

#include "assets/base/pose.h"
#include "haptics/geometry/triangle_bvh.h"

namespace tandem::haptics {

/// A mesh and where it stands.
struct PlacedMesh {
  const TriangleBvh* tree = nullptr;
  Pose worldFromMesh;
};

/// The nearest points of two meshes, world frame.
struct MeshGap {
  double distance = 0.0;          // m; 0 where the surfaces meet, independent of insides
  glm::dvec3 onA{0.0, 0.0, 0.0};  // m
  glm::dvec3 onB{0.0, 0.0, 0.0};  // m
  std::uint32_t triangleA = kNoTriangle, triangleB = kNoTriangle;
};

/// The least distance between two surfaces if it is at most `reach` (m); false if it is not, or if a mesh is
/// empty. Walks both trees at once with bounds from boxes and exact distances of triangles, in double. Of
/// several intersections with distance 0 the first one found is returned; the same arguments give the same
/// bits.
bool nearestPoints(const PlacedMesh& a, const PlacedMesh& b, double reach, MeshGap& gap);

}  // namespace tandem::haptics
