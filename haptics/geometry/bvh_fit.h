#pragma once

// Boxes and slabs of a TriangleBvh, fitted to its triangles in place.
//
// 1. Used by triangle_bvh.cpp, and leafTriangles() by sweep_front.cpp. Starts threads for large meshes; the
//    result does not depend on their number.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>

#include "haptics/geometry/triangle_bvh.h"
#include "haptics/geometry/triangle_filter.h"

namespace tandem::haptics {

/// The number of threads that a tree of this many triangles is worth; `threads`: how many there may be (0 =
/// all cores).
int workersFor(std::size_t triangles, int threads);

/// The extent of a mesh whose boxes have no origin yet.
MeshExtent extentOf(const assets::Mesh& mesh, int workers);

/// The triangles of a leaf relative to `origin`, given its first entry of the leaf order; the last one is
/// repeated where there are fewer than four.
inline Triangles4 leafTriangles(const assets::Mesh& mesh, const std::uint32_t* first, std::uint32_t count,
                                const glm::dvec3& origin) {
  const glm::dvec3* corners[3][4];
  for (std::uint32_t i = 0; i < 4; ++i) {
    const auto& t = mesh.triangles[first[std::min(i, count - 1)]];
    for (std::size_t k = 0; k < 3; ++k) corners[k][i] = &mesh.positions[t[k]];
  }
  return {gatherRelative(corners[0], origin), gatherRelative(corners[1], origin),
          gatherRelative(corners[2], origin)};
}

class BvhFit {
 public:
  /// All of them are those of the tree and must outlive the fit. `order` has the triangles in leaf order.
  BvhFit(const assets::Mesh& mesh, std::span<TriangleBvh::Node> nodes, std::span<const std::uint32_t> order,
         MeshExtent& extent)
      : mesh_(mesh), nodes_(nodes), order_(order), extent_(extent) {}

  /// Fits the slabs of all children, whose boxes fit.
  void fitSlabs(int workers) { fit(workers, false); }
  /// Fits boxes, slabs and extent after the triangles have moved. The origin of the boxes stays.
  void refit(int workers) { fit(workers, true); }

 private:
  void fit(int workers, bool haveMoved);
  /// Fits the slabs of the leaves of nodes [begin, end), and their boxes if the triangles have moved; other
  /// children get slab 0.
  void fitLeaves(std::size_t begin, std::size_t end, bool haveMoved);
  /// Fits the boxes of all children that are nodes.
  void fitInner();
  /// Fits the slabs of children that are nodes of [begin, end), last one first.
  void fitInnerSlabs(std::size_t begin, std::size_t end);

  const assets::Mesh& mesh_;
  std::span<TriangleBvh::Node> nodes_;
  std::span<const std::uint32_t> order_;
  MeshExtent& extent_;
};

}  // namespace tandem::haptics
