#pragma once

// The narrow phase: the exact contact between one sample of a part and the surface of another, which is the
// contact normal and the gap along it.
//
// Where two convex features meet, one separating axis is enough. The candidates are the directions that are
// normal to both, the edge's normals and the negated normals of the sample; the normal is the one along
// which the predicted positions are furthest apart. In a hollow all planes of the surface are contacts. A
// normal from the closest points alone makes a peg jam at the rim of its bore.

#include <array>
#include <cstdint>
#include <span>

#include <glm/vec3.hpp>

#include "haptics/geometry/mesh_edges.h"
#include "haptics/geometry/triangle_bvh.h"

namespace tandem::haptics {

/// A sample of the other part, in the frame of the mesh that is queried; m.
struct SampleQuery {
  glm::dvec3 point{0.0, 0.0, 0.0};
  glm::dvec3 motion{0.0, 0.0, 0.0};     // its predicted displacement in this step
  std::span<const glm::dvec3> normals;  // unit, outward from its own part
  glm::dvec3 edge{0.0, 0.0, 0.0};       // unit; zero where the sample is not on an edge
  double along = 0.0;                   // it stands for the edge up to this far on both sides
  double slack = 0.0;                   // by which a gap may be below zero where the predicted gap is not
  bool outside = false;                 // it is not inside the mesh
  bool shifted = false;                 // `point` lies beside the sample, by an interference fit
  double range = 0.0;                   // m that it may move before its next query
  double nearest = 1e300;               // m, at most how far the mesh is, for a field that knows
  std::span<const std::uint32_t> near;  // triangles of which one is nearest; empty: not known
};

/// A half-space that a point of the sample's part must not leave: normal . (point - surface) >= 0.
struct TouchingPlane {
  glm::dvec3 point{0.0, 0.0, 0.0};   // m
  glm::dvec3 normal{0.0, 0.0, 0.0};  // unit, away from the mesh
  double gap = 0.0;                  // m, of the point now; below 0 inside
};

/// The contact planes of a sample: that of the nearest feature, and beside a hollow edge the plane beyond
/// it; of a piece of edge, of the sample and of a deeper place beside it.
struct TouchingFeature {
  static constexpr int kMaxPlanes = 4;
  std::array<TouchingPlane, kMaxPlanes> planes;
  int count = 0;
  double distance = 0.0;  // m, from the first place to the mesh, without a sign
  double least = 1e300;   // m over the mesh, of all that the sample stands for, as far as it was seen
  std::uint32_t triangle = kNoTriangle;

  /// Adds the planes of another place of the same sample, none deeper than that place is in the mesh.
  void add(const TouchingFeature& other) {
    for (int k = 0; k < other.count && count < kMaxPlanes; ++k) {
      TouchingPlane& plane = planes[static_cast<std::size_t>(count++)];
      plane = other.planes[static_cast<std::size_t>(k)];
      plane.gap = plane.gap < -other.distance ? -other.distance : plane.gap;
    }
  }
};

/// The point of the mesh that is nearest to p, within `reach`; false if there is none. `near`: triangles of
/// which one is nearest, or none if they are not known; `hint`: a triangle that may be near, or any other
/// number.
bool nearestPoint(const TriangleBvh& tree, std::span<const std::uint32_t> near, const glm::dvec3& p,
                  double reach, std::uint32_t hint, MeshPoint& nearest);

/// False if the mesh is further than `reach` away. `hint`: a triangle that may be near, or any other number.
bool touchingFeature(const TriangleBvh& tree, const MeshEdges& edges, const SampleQuery& sample, double reach,
                     std::uint32_t hint, TouchingFeature& found);

/// The plane of one convex edge, which is near the sample.
TouchingPlane touchingEdge(const MeshEdge& edge, const SampleQuery& sample);

}  // namespace tandem::haptics
