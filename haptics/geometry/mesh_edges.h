#pragma once

// Edges of a mesh: its convex and concave edges, and those around each triangle.
//
// 1. Immutable, in the part's frame. An edge between coplanar faces is left out. Four bytes of each are kept:
//    all else follows from the mesh, which must outlive this.
// 2. An open border within a slit's width of another forms an edge with the face beyond the slit.
// 3. Any other forms a convex edge with its own back, since a sheet has two sides. The back of a face of a
//    solid cannot be touched: there the border forms a right edge with the plane in which the face ends.

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include "assets/scene/scene.h"

namespace tandem::haptics {

struct MeshPoint;

/// Where an edge runs, between two faces or at the border of one.
struct EdgeLine {
  glm::dvec3 a{0.0, 0.0, 0.0}, b{0.0, 0.0, 0.0};  // m
  std::array<std::uint32_t, 2> triangles{};       // equal at a border without a slit
  std::array<std::uint32_t, 2> ends{};            // vertices of the mesh
  bool border = false;                            // the mesh has one face here
};

/// An edge, and how the surface turns there.
struct MeshEdge : EdgeLine {
  std::array<glm::dvec3, 2> normals{};  // unit, outward, of the faces
  double angle = 0.0;                   // rad between the normals, below 0 where the edge is concave
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
  /// Whether the angle is above 0. This costs one load, line() some, and the rest is computed.
  bool isConvex(std::uint32_t index) const { return (kept_[index] & kConcave) == 0; }
  EdgeLine line(std::uint32_t index) const;
  std::array<glm::dvec3, 2> normals(std::uint32_t index) const;
  double angle(std::uint32_t index) const;
  MeshEdge edge(std::uint32_t index) const { return {line(index), normals(index), angle(index)}; }
  /// Indices of the edges of a triangle, and of the triangles beside it in its plane, up to two away.
  std::span<const std::uint32_t> around(std::uint32_t triangle) const {
    return {around_.data() + listAt(triangle), around_.data() + listAt(triangle + 1)};
  }
  /// Outward unit normal; zero for a triangle without area.
  glm::dvec3 normal(std::uint32_t triangle) const;
  /// Distance between sharp edges, m: in cubes of side `cube`, the area of a cube's face over the length of
  /// edges in it, as the median over edge length. `cube` itself where edges are isolated; less in a thread or
  /// a comb.
  double sharpSpacing(double cube) const;
  std::size_t memory() const;

 private:
  // Of an edge is kept: flags and, below them, 4 t + e for edge e of triangle t, or its place in borders_.
  static constexpr std::uint32_t kBorder = 1u << 31, kConcave = 1u << 30, kPlace = kConcave - 1;
  static constexpr std::uint32_t kGroup = 64;
  struct Place {
    std::uint32_t triangle, edge;
    std::uint32_t other;  // the face across the edge or a slit; kNone: the back of the triangle
    bool border;
  };
  /// The triangle across an edge or across the slit there, or kNone.
  using Beyond = std::vector<std::array<std::uint32_t, 3>>;

  void findEdges(const Beyond& beyond, std::vector<std::array<std::uint32_t, 3>>& edgeOf);
  void listAround(const Beyond& beyond, const std::vector<std::array<std::uint32_t, 3>>& edgeOf);
  std::uint32_t listAt(std::uint32_t triangle) const {
    return group_[triangle / kGroup] + inGroup_[triangle];
  }
  Place place(std::uint32_t index) const {
    const std::uint32_t at = kept_[index] & kPlace;
    if ((kept_[index] & kBorder) != 0) return borders_[at];
    return {at >> 2, at & 3, mesh_->neighbours[at >> 2][at & 3], false};
  }

  const assets::Mesh* mesh_ = nullptr;
  bool ofSolid_ = false;
  std::vector<std::uint32_t> kept_;
  std::vector<Place> borders_;
  std::vector<std::uint32_t> group_;    // per kGroup triangles: into around_
  std::vector<std::uint16_t> inGroup_;  // per triangle and one more: where its list begins in its group's
  std::vector<std::uint32_t> around_;   // into kept_
};

// Who asks often needs only the ends, or only the triangles, and the compiler then leaves out the rest.
[[gnu::always_inline]] inline EdgeLine MeshEdges::line(std::uint32_t index) const {
  const Place at = place(index);
  const auto& corners = mesh_->triangles[at.triangle];
  const std::uint32_t a = corners[at.edge], b = corners[at.edge < 2 ? at.edge + 1 : 0];
  return {mesh_->positions[a],
          mesh_->positions[b],
          {at.triangle, at.other == assets::kNone ? at.triangle : at.other},
          {a, b},
          at.border};
}

inline glm::dvec3 MeshEdges::normal(std::uint32_t triangle) const {
  const auto& c = mesh_->triangles[triangle];
  const glm::dvec3& a = mesh_->positions[c[0]];
  const glm::dvec3 area = glm::cross(mesh_->positions[c[1]] - a, mesh_->positions[c[2]] - a);
  const double length = glm::length(area);
  return length > 0.0 ? area / length : glm::dvec3(0.0);
}

/// Whether p is behind the surface at the surface's nearest point. On an edge or in a corner p must be behind
/// every face that meets there, because before a sharp edge one face alone may be wrong.
bool isBehind(const MeshEdges& edges, const MeshPoint& nearest, const glm::dvec3& p);

}  // namespace tandem::haptics
