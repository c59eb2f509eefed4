#pragma once

// How far two triangle meshes are from each other, exactly: the least distance between their surfaces, with
// the points and triangles where it is found. For reviews of an assembly, never in a tick: it allocates.
//
// Safe in every thread: trees are only read.

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
  double distance = 0.0;          // m; 0 where the surfaces meet, which tells nothing of insides
  glm::dvec3 onA{0.0, 0.0, 0.0};  // m
  glm::dvec3 onB{0.0, 0.0, 0.0};  // m
  std::uint32_t triangleA = kNoTriangle, triangleB = kNoTriangle;
};

/// The least distance between two surfaces if it is at most `reach` (m); false if it is not or a mesh is
/// empty. Both trees are walked at once; boxes give bounds, triangles the answer, in double. Of meetings with
/// distance 0 the first one found is told; the same arguments give the same bits.
bool nearestPoints(const PlacedMesh& a, const PlacedMesh& b, double reach, MeshGap& gap);

}  // namespace tandem::haptics
