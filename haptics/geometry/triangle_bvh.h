#pragma once

// Bounding volume hierarchy over the triangles of one mesh: nearest points, and swept tests of a moving ball.
//
// 1. Boxes are floats, rounded outwards and relative to the mesh's centre; decisions on triangles are in
//    double.
// 2. A node has four children, a leaf at most kMaxLeaf triangles, and the depth is at most kMaxDepth, so
//    queries use a fixed stack.
// 3. Immutable between construction and refit(), and safe in every thread. The tree does not depend on the
//    number of threads.
// 4. The mesh must outlive the tree.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "assets/scene/scene.h"
#include "haptics/base/section.h"
#include "haptics/base/simd4.h"
#include "haptics/geometry/triangle_math.h"

namespace tandem::haptics {

inline constexpr std::uint32_t kNoTriangle = 0xffffffffu;

/// Nearest point of a mesh.
struct MeshPoint {
  double distance = 0.0;  // m
  std::uint32_t triangle = kNoTriangle;
  glm::dvec3 point{0.0, 0.0, 0.0};
  bool onFace = false;
};

/// A leaf of a tree near a point.
struct NearLeaf {
  double atLeast = 0.0;                  // m: no triangle of the mesh is nearer
  std::uint32_t triangle = kNoTriangle;  // one of the leaf's
};

/// First contact of a moving ball with a mesh.
struct MeshBallHit : BallHit {
  std::uint32_t triangle = kNoTriangle;
};

/// Where the points of a mesh lie.
struct MeshExtent {
  glm::dvec3 centre{0.0, 0.0, 0.0};  // m, mesh frame: the origin of the tree's boxes
  assets::Bounds bounds;             // exact
  float largest = 0.0f;              // m, largest coordinate relative to the centre
};

class TriangleBvh {
 public:
  static constexpr int kMaxLeaf = 4;
  static constexpr int kMaxDepth = 64;

  /// Builds by the binned surface-area heuristic (Wald 2007, "On fast construction of SAH-based bounding
  /// volume hierarchies"), here with direct four-way nodes and subtrees built on up to `threads` threads (0 =
  /// all cores).
  explicit TriangleBvh(const assets::Mesh& mesh, int threads = 0);

  /// Refits boxes and slabs in the existing tree after positions of the mesh have changed in place; the
  /// triangles must be the same. Results stay exact, and queries slow down as triangles move away from their
  /// old neighbours. Must not run during a query. Allocates, and starts threads for large meshes.
  void refit(int threads = 0);

  /// The nearest point within `maxDistance` of p; false if there is none. Of this query and those below, only
  /// what `cut` leaves of the mesh counts, in its frame, if not null.
  bool closestPoint(const glm::dvec3& p, double maxDistance, MeshPoint& nearest,
                    const Sections* cut = nullptr) const;

  /// The same among the given triangles alone, without the tree: where the nearest one is known to be one of
  /// a few.
  bool closestPointAmong(std::span<const std::uint32_t> triangles, const glm::dvec3& p, double maxDistance,
                         MeshPoint& nearest) const;

  /// The leaf whose box and slab are nearest to p, as far as they are within `reach`, else a bound of `reach`
  /// and no triangle. Tests no triangle, which makes it several times as fast as closestPoint().
  NearLeaf nearestLeaf(const glm::dvec3& p, double reach) const;

  /// The first triangle that a ball moving from `from` by `motion` meets earlier than hit.t; see sweepBall()
  /// of triangle_math.h. On a tie the triangle that the ball meets most squarely wins.
  bool sweepBall(const glm::dvec3& from, const glm::dvec3& motion, double radius, double tolerance,
                 MeshBallHit& hit, const Sections* cut = nullptr) const;

  /// Number of outward less inward crossings of a segment with the surface: the winding number of `from` if
  /// the segment ends outside, except where it hits an edge exactly.
  int signedCrossings(const glm::dvec3& from, const glm::dvec3& to, const Sections* cut = nullptr) const;

  /// Writes the triangles whose boxes meet `box`. Returns their number; only the first found.size() are
  /// stored.
  std::size_t gather(const assets::Bounds& box, std::span<std::uint32_t> found) const;

  Triangle triangle(std::uint32_t index) const {
    const auto& corners = mesh_->triangles[index];
    return {mesh_->positions[corners[0]], mesh_->positions[corners[1]], mesh_->positions[corners[2]]};
  }
  const assets::Mesh& mesh() const { return *mesh_; }
  const assets::Bounds& bounds() const { return extent_.bounds; }  // exact, of the points of the mesh
  bool empty() const { return order_.empty(); }
  std::size_t memory() const { return nodeCount_ * sizeof(Node) + order_.size() * sizeof(std::uint32_t); }
  /// Levels of nodes; for tests.
  int depth() const;

  /// Four child boxes side by side, m relative to the centre. A child is a node index, or a leaf: kLeafBit,
  /// the count in the next three bits, and the first entry of order_ in the rest; kEmptyChild means none.
  /// `slab` holds the flatness of a child: a direction N of three signed bytes (x lowest), and in the top
  /// byte h with
  ///     N . (x - c) <= h / 128 * (|N_x|, |N_y|, |N_z|) . e
  /// for all points x of its triangles, with c and e the box's centre and half extents; 0 means no slab. See
  /// leaf_slab.h.
  struct alignas(64) Node {
    float low[3][4];
    float high[3][4];
    std::uint32_t child[4];
    std::uint32_t slab[4];

    Vec4 lows() const { return {Float4::load(low[0]), Float4::load(low[1]), Float4::load(low[2])}; }
    Vec4 highs() const { return {Float4::load(high[0]), Float4::load(high[1]), Float4::load(high[2])}; }
  };
  static constexpr std::uint32_t kLeafBit = 0x80000000u;
  static constexpr std::uint32_t kEmptyChild = 0xffffffffu;
  static constexpr std::uint32_t kLeafFirstMask = 0x0fffffffu;

  static std::uint32_t leafCount(std::uint32_t child) { return (child >> 28) & 7u; }

  /// For walks over two trees at once. nodes()[0] is the root (absent where empty()); boxes are relative to
  /// centre(); leafTriangle(i) is the triangle at place i of the leaf order.
  std::span<const Node> nodes() const { return {nodes_.get(), nodeCount_}; }
  const glm::dvec3& centre() const { return extent_.centre; }  // m, mesh frame
  std::uint32_t leafTriangle(std::uint32_t place) const { return order_[place]; }
  const std::uint32_t* leafTriangles(std::uint32_t place) const { return order_.data() + place; }
  float largest() const { return extent_.largest; }  // m, coordinate relative to centre()
  /// Rounding of a difference of coordinates near p, m; float filters add it to their own error.
  double coordinateRounding(const glm::dvec3& p) const {
    return 0x1p-48 * (glm::length(extent_.centre) + extent_.largest + glm::length(p));
  }

 private:
  template <typename Visit>
  void forEachInBox(const assets::Bounds& box, Visit&& visit) const;

  const assets::Mesh* mesh_;
  MeshExtent extent_;
  std::unique_ptr<Node[]> nodes_;  // nodes_[0] is the root
  std::size_t nodeCount_ = 0;
  std::vector<std::uint32_t> order_;  // triangles in leaf order
};

}  // namespace tandem::haptics
