#pragma once

// Edges of a mesh: its convex and concave edges, and those around each triangle.
//
// 1. Immutable, in the part's frame. An edge between coplanar faces is left out. 32 bytes of each are kept;
//    its ends and normals are those of the mesh, which must outlive this.
// 2. An open border within a slit's width of another forms an edge with the face beyond the slit.
// 3. Any other forms a convex edge with its own back, since a sheet has two sides. The back of a face of a
//    solid cannot be touched: there the border forms a right edge with the plane in which the face ends.

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "assets/scene/scene.h"

namespace tandem::haptics {

struct MeshPoint;

/// An edge between two faces, or at the border of one.
struct MeshEdge {
  glm::dvec3 a{0.0, 0.0, 0.0}, b{0.0, 0.0, 0.0};  // m
  std::array<glm::dvec3, 2> normals{};            // unit, outward, of the faces
  std::array<std::uint32_t, 2> triangles{};       // equal at a border without a slit
  std::array<std::uint32_t, 2> ends{};            // vertices of the mesh
  double angle = 0.0;   // rad between the normals, below 0 where the edge is concave
  bool border = false;  // the mesh has one face here
};

class MeshEdges {
 public:
  explicit MeshEdges(const assets::Mesh& mesh);
  explicit MeshEdges(const assets::Mesh&& mesh) = delete;
  /// An empty set, for a part that is queried by formula.
  MeshEdges() = default;

  /// The same edges as those of a solid (3).
  MeshEdges ofSolid() &&;

  std::uint32_t count() const { return static_cast<std::uint32_t>(kept_.size()); }
  MeshEdge edge(std::uint32_t index) const;
  /// Indices of the edges of a triangle, and of the triangles beside it in its plane, up to two away.
  std::span<const std::uint32_t> around(std::uint32_t triangle) const {
    return {around_.data() + first_[triangle], around_.data() + first_[triangle + 1]};
  }
  /// Outward unit normal; zero for a triangle without area.
  const glm::dvec3& normal(std::uint32_t triangle) const { return normals_[triangle]; }
  /// Distance between sharp edges, m: in cubes of side `cube`, the area of a cube's face over the length of
  /// edges in it, as the median over edge length. `cube` itself where edges are isolated; less in a thread or
  /// a comb.
  double sharpSpacing(double cube) const;
  std::size_t memory() const;

 private:
  struct Kept {
    std::array<std::uint32_t, 2> ends{}, triangles{};
    double angle = 0.0;
    bool border = false;
    /// Into backs_: the second normal, where it is no triangle's; or kNone.
    std::uint32_t back = assets::kNone;
  };
  /// The triangle across an edge or across the slit there, or kNone.
  using Beyond = std::vector<std::array<std::uint32_t, 3>>;
  void findEdges(const assets::Mesh& mesh, const Beyond& beyond,
                 std::vector<std::array<std::uint32_t, 3>>& edgeOf);
  void listAround(const Beyond& beyond, const std::vector<std::array<std::uint32_t, 3>>& edgeOf);

  const assets::Mesh* mesh_ = nullptr;
  std::vector<Kept> kept_;
  std::vector<glm::dvec3> normals_;    // per triangle
  std::vector<glm::dvec3> backs_;      // second normals of borders without a slit
  std::vector<std::uint32_t> first_;   // per triangle and one more: into around_
  std::vector<std::uint32_t> around_;  // into kept_
};

// Who asks often needs an end or the angle alone, and the compiler then leaves out the rest.
[[gnu::always_inline]] inline MeshEdge MeshEdges::edge(std::uint32_t index) const {
  const Kept& kept = kept_[index];
  const glm::dvec3& second = kept.back == assets::kNone ? normals_[kept.triangles[1]] : backs_[kept.back];
  return {mesh_->positions[kept.ends[0]],
          mesh_->positions[kept.ends[1]],
          {normals_[kept.triangles[0]], second},
          kept.triangles,
          kept.ends,
          kept.angle,
          kept.border};
}

/// Whether p is behind the surface at the surface's nearest point. On an edge or in a corner p must be behind
/// every face that meets there, because before a sharp edge one face alone may be wrong.
bool isBehind(const MeshEdges& edges, const MeshPoint& nearest, const glm::dvec3& p);

}  // namespace tandem::haptics
