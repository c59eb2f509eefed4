#include "haptics/geometry/mesh_intrusion.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <queue>

#include <glm/common.hpp>
#include <glm/vector_relational.hpp>

#include "assets/base/assert.h"
#include "haptics/geometry/placed_bounds.h"

namespace tandem::haptics {
namespace {

constexpr double kEverywhere = std::numeric_limits<double>::max();
constexpr double kBetter = 1.01;  // improvement that an edge or a face must promise to be searched

/// A triangle cut across its longest edge.
std::array<Triangle, 2> halves(const Triangle& t) {
  const double ab = glm::length(t.b - t.a), bc = glm::length(t.c - t.b), ca = glm::length(t.a - t.c);
  if (ab >= bc && ab >= ca) return {{{t.a, 0.5 * (t.a + t.b), t.c}, {0.5 * (t.a + t.b), t.b, t.c}}};
  if (bc >= ca) return {{{t.a, t.b, 0.5 * (t.b + t.c)}, {t.a, 0.5 * (t.b + t.c), t.c}}};
  return {{{t.a, t.b, 0.5 * (t.c + t.a)}, {t.b, t.c, 0.5 * (t.c + t.a)}}};
}

/// Union-find: sets of vertices that merge.
class Groups {
 public:
  explicit Groups(std::size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), 0u); }
  std::uint32_t find(std::uint32_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void join(std::uint32_t i, std::uint32_t j) {
    i = find(i), j = find(j);
    parent_[std::max(i, j)] = std::min(i, j);
  }

 private:
  std::vector<std::uint32_t> parent_;
};

/// One mesh against the other, `solid`, in whose frame everything is measured.
class Intruder {
 public:
  Intruder(const TriangleBvh& mesh, const TriangleBvh& solid, const Pose& solidFromMesh, double tolerance,
           bool cross)
      : mesh_(mesh), solid_(solid), solidFromMesh_(solidFromMesh), tolerance_(tolerance), cross_(cross) {}

  /// `touched` are the triangles of the mesh within the tolerance of the solid's surface, `cuts` the
  /// crossings of their edges.
  void search(const std::vector<std::uint32_t>& touched, std::vector<EdgeCut>& cuts, Deepest& best) {
    const std::vector<std::uint32_t> nearby = trianglesInReach();
    std::vector<std::uint8_t> isTouched(mesh_.mesh().triangles.size(), 0);
    for (const std::uint32_t t : touched) isTouched[t] = 1;
    findInside(nearby, isTouched);
    searchCorners(best);
    searchEdges(nearby, isTouched, cuts, best);
    searchFaces(nearby, isTouched, best);
  }

 private:
  /// An interval of an edge, and an upper bound of its depth.
  struct Piece {
    double bound;
    std::uint32_t from, to;
    double begin, end;            // fractions of the edge
    double depthBegin, depthEnd;  // m, signed, at least the true ones
    bool operator<(const Piece& other) const {
      if (bound != other.bound) return bound < other.bound;
      if (from != other.from) return from > other.from;
      return to != other.to ? to > other.to : begin > other.begin;
    }
  };

  /// A piece of a triangle, and an upper bound of the depth of its points.
  struct Patch {
    double bound;
    Triangle t;
    std::uint64_t order;  // breaks ties between equal bounds
    bool operator<(const Patch& other) const {
      return bound != other.bound ? bound < other.bound : order > other.order;
    }
  };

  int maxSamples(const Deepest& best) const {
    return cross_ || best.depth > tolerance_ ? kMaxSamples : kFewSamples;
  }
  /// The bound from which a piece is searched.
  double enough(const Deepest& best) const { return std::max(kBetter * best.depth, tolerance_); }

  glm::dvec3 corner(std::uint32_t vertex) const {
    return transformPoint(solidFromMesh_, mesh_.mesh().positions[vertex]);
  }

  std::vector<std::uint32_t> trianglesInReach() const {
    const Pose meshFromSolid = inverse(solidFromMesh_);
    assets::Bounds reach = boundsAt(solid_.bounds(), meshFromSolid);
    reach.min -= tolerance_;
    reach.max += tolerance_;
    std::vector<std::uint32_t> found(mesh_.gather(reach, {}));
    mesh_.gather(reach, found);
    return found;
  }

  /// Finds the vertices of the mesh that are inside. A triangle that is not touched is wholly inside or
  /// outside, and so is each group connected by such triangles: one test per group.
  void findInside(const std::vector<std::uint32_t>& nearby, const std::vector<std::uint8_t>& isTouched) {
    const auto& triangles = mesh_.mesh().triangles;
    Groups groups(mesh_.mesh().positions.size());
    std::vector<std::uint8_t> isNear(mesh_.mesh().positions.size(), 0);
    for (const std::uint32_t t : nearby) {
      const auto& corners = triangles[t];
      for (const std::uint32_t v : corners) isNear[v] = 1;
      if (isTouched[t] != 0) continue;
      groups.join(corners[0], corners[1]);
      groups.join(corners[1], corners[2]);
    }
    vertices_.clear();
    for (std::uint32_t v = 0; v < isNear.size(); ++v) {
      if (isNear[v] != 0) vertices_.push_back(v);
    }
    inside_.assign(mesh_.mesh().positions.size(), 0);
    // The root of a group is its lowest vertex, so it is tested before the others.
    for (const std::uint32_t v : vertices_) {
      const std::uint32_t root = groups.find(v);
      inside_[v] =
          root == v ? static_cast<std::uint8_t>(containsPoint(solid_, corner(v)) ? 1 : 0) : inside_[root];
    }
  }

  void keepDeepest(const glm::dvec3& p, const MeshPoint& nearest, Deepest& best) const {
    if (nearest.distance <= best.depth) return;
    best = {nearest.distance, p, nearest.point - p, true};
  }

  void searchCorners(Deepest& best) const {
    for (const std::uint32_t v : vertices_) {
      if (inside_[v] == 0) continue;
      const glm::dvec3 p = corner(v);
      MeshPoint nearest;
      if (best.depth > 0.0 && solid_.closestPoint(p, best.depth, nearest)) continue;
      if (solid_.closestPoint(p, kEverywhere, nearest)) keepDeepest(p, nearest, best);
    }
  }

  void push(Piece piece, const Deepest& best) {
    const double length = (piece.end - piece.begin) * glm::length(corner(piece.to) - corner(piece.from));
    piece.bound = 0.5 * (piece.depthBegin + piece.depthEnd + length);
    if (piece.bound > enough(best)) pieces_.push(piece);
  }

  void searchEdges(const std::vector<std::uint32_t>& nearby, const std::vector<std::uint8_t>& isTouched,
                   std::vector<EdgeCut>& cuts, Deepest& best) {
    pieces_ = {};
    for (const std::uint32_t t : nearby) {
      const auto& corners = mesh_.mesh().triangles[t];
      if (isTouched[t] != 0 || inside_[corners[0]] == 0) continue;
      for (std::size_t e = 0; e < 3; ++e) {
        const std::uint32_t from = corners[e], to = corners[(e + 1) % 3];
        if (from < to) push({0.0, from, to, 0.0, 1.0, best.depth, best.depth}, best);
      }
    }
    pushCutEdges(cuts, best);
    for (int samples = 0; samples < maxSamples(best) && !pieces_.empty(); ++samples) {
      const Piece piece = pieces_.top();
      pieces_.pop();
      if (piece.bound <= enough(best)) break;
      halve(piece, best);
    }
  }

  /// Pushes the pieces between the cuts of an edge; the ends of these pieces are on the surface.
  void pushCutEdges(std::vector<EdgeCut>& cuts, const Deepest& best) {
    std::sort(cuts.begin(), cuts.end(), [](const EdgeCut& a, const EdgeCut& b) {
      if (a.from != b.from) return a.from < b.from;
      return a.to != b.to ? a.to < b.to : a.share < b.share;
    });
    for (std::size_t i = 0; i < cuts.size(); ++i) {
      const EdgeCut& cut = cuts[i];
      const bool first = i == 0 || cuts[i - 1].from != cut.from || cuts[i - 1].to != cut.to;
      const bool last = i + 1 == cuts.size() || cuts[i + 1].from != cut.from || cuts[i + 1].to != cut.to;
      if (first) push({0.0, cut.from, cut.to, 0.0, cut.share, best.depth, 0.0}, best);
      push({0.0, cut.from, cut.to, cut.share, last ? 1.0 : cuts[i + 1].share, 0.0, last ? best.depth : 0.0},
           best);
    }
  }

  void halve(const Piece& piece, Deepest& best) {
    const double middle = 0.5 * (piece.begin + piece.end);
    const glm::dvec3 from = corner(piece.from);
    const double depth = sample(from + (corner(piece.to) - from) * middle, best);
    push({0.0, piece.from, piece.to, piece.begin, middle, piece.depthBegin, depth}, best);
    push({0.0, piece.from, piece.to, middle, piece.end, depth, piece.depthEnd}, best);
  }

  /// The depth of a point, negative outside; its sign does not matter at the surface.
  double sample(const glm::dvec3& p, Deepest& best) const {
    MeshPoint nearest;
    if (!solid_.closestPoint(p, kEverywhere, nearest)) return 0.0;
    if (nearest.distance <= tolerance_) return nearest.distance;
    if (!containsPoint(solid_, p)) return -nearest.distance;
    keepDeepest(p, nearest, best);
    return nearest.distance;
  }

  void searchFaces(const std::vector<std::uint32_t>& nearby, const std::vector<std::uint8_t>& isTouched,
                   Deepest& best) const {
    std::priority_queue<Patch> patches;
    std::uint64_t order = 0;
    const auto halve = [&](const Patch& patch) {
      const glm::dvec3 centre = (patch.t.a + patch.t.b + patch.t.c) / 3.0;
      const double depth = sample(centre, best);
      for (const Triangle& half : halves(patch.t)) {
        const double radius = std::max(
            {glm::length(half.a - centre), glm::length(half.b - centre), glm::length(half.c - centre)});
        const double bound = std::min(patch.bound, depth + radius);
        if (bound > enough(best)) patches.push({bound, half, order++});
      }
    };
    for (const std::uint32_t i : nearby) {
      const auto& corners = mesh_.mesh().triangles[i];
      if (isTouched[i] == 0 && inside_[corners[0]] == 0) continue;
      const Triangle t{corner(corners[0]), corner(corners[1]), corner(corners[2])};
      // A piece with a point at the surface, or without a corner deeper than the best, is bounded by its
      // longest side.
      const double longest =
          std::max({glm::length(t.b - t.a), glm::length(t.c - t.b), glm::length(t.a - t.c)});
      const double bound = isTouched[i] != 0 ? tolerance_ + longest : best.depth + longest / std::sqrt(3.0);
      if (bound <= enough(best)) continue;
      if (isTouched[i] != 0) {
        halve({bound, t, 0});
      } else {
        patches.push({bound, t, order++});
      }
    }
    for (int samples = 0; samples < maxSamples(best) && !patches.empty(); ++samples) {
      const Patch patch = patches.top();
      patches.pop();
      if (patch.bound <= enough(best)) break;
      halve(patch);
    }
  }

  const TriangleBvh &mesh_, &solid_;
  Pose solidFromMesh_;
  double tolerance_;
  bool cross_;                           // the surfaces cross each other
  std::vector<std::uint32_t> vertices_;  // of triangles in reach, ascending
  std::vector<std::uint8_t> inside_;     // one per vertex of the mesh
  std::priority_queue<Piece> pieces_;
};

}  // namespace

bool containsPoint(const TriangleBvh& tree, const glm::dvec3& p) {
  const assets::Bounds& box = tree.bounds();
  if (tree.empty() || glm::any(glm::lessThan(p, box.min)) || glm::any(glm::greaterThan(p, box.max))) {
    return false;
  }
  // Directions without zero or equal components, because CAD faces are axis-parallel and their edges often at
  // 45 degrees.
  static constexpr double kRays[3][3] = {{1.0, 0.137, 0.271}, {-0.193, 1.0, -0.311}, {0.229, -0.173, -1.0}};
  const double length = 1.5 * glm::length(box.max - box.min);
  int inside = 0, outside = 0;
  for (const auto& ray : kRays) {
    for (const double side : {length, -length}) {
      const glm::dvec3 path = glm::dvec3(ray[0], ray[1], ray[2]) * side;
      ++(tree.signedCrossings(p, p + path) != 0 ? inside : outside);
      if (outside > 1) return false;
    }
  }
  return inside >= 5;
}

Deepest deepestInside(const TriangleBvh& mesh, const TriangleBvh& solid, const Pose& solidFromMesh,
                      const std::vector<std::uint32_t>& touched, std::vector<EdgeCut> cuts, double tolerance,
                      bool cross) {
  ASSERT(tolerance >= 0.0);
  for (const std::uint32_t t : touched) ASSERT(t < mesh.mesh().triangles.size());
  for (const EdgeCut& cut : cuts) ASSERT(cut.from <= cut.to && cut.to < mesh.mesh().positions.size());
  Deepest best;
  Intruder(mesh, solid, solidFromMesh, tolerance, cross).search(touched, cuts, best);
  return best;
}

}  // namespace tandem::haptics
