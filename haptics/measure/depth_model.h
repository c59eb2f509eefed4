#pragma once

// A mesh for the measurement of penetration: the same surface in fewer and larger pieces.
//
// 1. Coplanar triangles form one facet, collinear edges one ridge; what is left out lies within tolerance()
//    of what represents it.
// 2. Immutable after construction; keeps no reference to the mesh. Not for ticks: it allocates.

#include <cstdint>
#include <memory>
#include <vector>

#include "assets/scene/scene.h"
#include "haptics/geometry/segment_tree.h"
#include "haptics/geometry/triangle_bvh.h"

namespace tandem::haptics {

/// A straight edge at which the surface is convex, or where a surface ends.
struct DepthRidge {
  std::uint32_t from = 0, to = 0;  // corners
};

class DepthModel {
 public:
  /// O(T log T). A mesh without topology is welded first (assets/mesh/mesh_analysis.h).
  explicit DepthModel(const assets::Mesh& mesh);
  DepthModel(const DepthModel&) = delete;
  DepthModel& operator=(const DepthModel&) = delete;

  /// Whether every edge joins two consistently oriented triangles, so that the surface has an inside.
  bool solid() const { return solid_; }
  /// Diagonal of the bounds, m.
  double size() const { return size_; }
  double tolerance() const { return kTolerance * size_; }
  const assets::Bounds& bounds() const { return surface_.bounds; }
  const std::vector<glm::dvec3>& corners() const { return surface_.positions; }
  const std::vector<DepthRidge>& ridges() const { return ridges_; }
  std::size_t facetCount() const { return facets_.empty() ? 0 : facets_.size() - 1; }
  const TriangleBvh& tree() const { return *tree_; }
  std::uint32_t facetOf(std::uint32_t triangle) const { return facetOf_[triangle]; }
  /// Unit, outwards where the mesh is solid.
  const glm::dvec3& normal(std::uint32_t facet) const { return normals_[facet]; }

  /// An upper bound of the distance from p to the surface that is convex in p: the distance to a facet.
  double distanceToFacet(std::uint32_t facet, const glm::dvec3& p) const;
  /// Whether a point of a facet's plane lies within its border.
  bool withinFacet(std::uint32_t facet, const glm::dvec3& p) const;

  /// Crossings of a segment with the surface, unordered; see SegmentTree.
  void crossings(const glm::dvec3& from, const glm::dvec3& to, std::vector<SegmentCrossing>& found) const {
    segments_->crossings(from, to, found);
  }
  /// Whether p is inside the solid: by the nearest facet where that lies under p, else by the majority of
  /// rays.
  bool inside(const glm::dvec3& p, const MeshPoint& nearest) const;
  bool inside(const glm::dvec3& p) const;

 private:
  static constexpr double kTolerance = 1e-7;  // of the size

  friend class DepthModelBuilder;

  bool solid_ = false;
  double size_ = 0.0;
  assets::Mesh surface_;                // of the facets, without topology
  std::vector<std::uint32_t> facetOf_;  // of a triangle of surface_
  std::vector<std::uint32_t> facets_;   // start of each facet's corners in border_; one more at the end
  std::vector<std::uint32_t> border_;   // corners, counter-clockwise
  std::vector<glm::dvec3> normals_;
  std::vector<DepthRidge> ridges_;
  std::unique_ptr<TriangleBvh> tree_;
  std::unique_ptr<SegmentTree> segments_;
};

}  // namespace tandem::haptics
