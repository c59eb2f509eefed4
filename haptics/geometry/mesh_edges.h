#pragma once

// Where the surface of a mesh turns: its convex and concave edges, and which of them lie around a triangle.
//
// 1. Immutable, in the part's frame; an edge between faces that are one plane is left out.
// 2. A face that stands alone on an edge (an open border) makes a convex edge with the face's own back.

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "assets/scene/scene.h"

namespace tandem::haptics {

/// An edge between two faces, or at the border of one.
struct MeshEdge {
  glm::dvec3 a{0.0, 0.0, 0.0}, b{0.0, 0.0, 0.0};  // m
  std::array<glm::dvec3, 2> normals{};            // unit, outward, of the faces
  std::array<std::uint32_t, 2> triangles{};       // equal at a border
  std::array<std::uint32_t, 2> ends{};            // vertices of the mesh
  double angle = 0.0;  // rad between the normals, below 0 where the edge is concave
};

class MeshEdges {
 public:
  explicit MeshEdges(const assets::Mesh& mesh);
  /// None: of a part that is asked by formula.
  MeshEdges() = default;

  std::span<const MeshEdge> edges() const { return edges_; }
  /// Indices of the edges of a triangle, and of those of the triangles beside it in its plane, two away.
  std::span<const std::uint32_t> around(std::uint32_t triangle) const {
    return {around_.data() + first_[triangle], around_.data() + first_[triangle + 1]};
  }
  /// Outward unit normal; zero for a triangle without area.
  const glm::dvec3& normal(std::uint32_t triangle) const { return normals_[triangle]; }
  /// How far apart sharp edges are, m: in cubes of side `cube`, the face of a cube over the length of edges in it; half
  /// of that length is in narrower places. `cube` itself where they stand alone; less in a thread or a comb.
  double sharpSpacing(double cube) const;
  std::size_t memory() const;

 private:
  void findEdges(const assets::Mesh& mesh, std::vector<std::array<std::uint32_t, 3>>& edgeOf);
  void listAround(const assets::Mesh& mesh, const std::vector<std::array<std::uint32_t, 3>>& edgeOf);

  std::vector<MeshEdge> edges_;
  std::vector<glm::dvec3> normals_;    // a triangle
  std::vector<std::uint32_t> first_;   // a triangle, and one more: into around_
  std::vector<std::uint32_t> around_;  // into edges_
};

}  // namespace tandem::haptics
