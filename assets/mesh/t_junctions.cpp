#include "assets/mesh/t_junctions.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <glm/geometric.hpp>

#include "assets/base/assert.h"
#include "assets/base/buckets.h"
#include "assets/base/point_tree.h"
#include "assets/scene/scene.h"

namespace tandem::assets {
namespace {

/// Steps of a search an open edge, on the mean. A search takes some tens; long edges that cross a cloud of
/// vertices take more.
constexpr std::size_t kStepsPerEdge = 512;
constexpr std::size_t kLeastSteps = std::size_t{1} << 20;
/// Two faces are folded onto each other where both reach further than this many tolerances from their edge,
/// to the same side, and the lower one lies within a few tolerances of the other's plane.
constexpr double kReaching = 64.0, kFolded = 4.0;

/// A vertex on an edge.
struct Junction {
  std::uint32_t vertex = 0;
  double along = 0.0;  // share of the edge, 0..1
};

/// The open edges of a mesh, the vertices that lie on them, and those of them that are T-junctions.
class OpenEdges {
 public:
  OpenEdges(const std::vector<glm::dvec3>& points, const std::vector<TriangleIndices>& triangles,
            const EdgePairs& pairs, double tolerance)
      : points_(points), triangles_(triangles), tolerance_(tolerance) {
    for (std::uint32_t h = 0; h < pairs.across.size(); ++h)
      if (pairs.across[h] == kOpenEdge) edges_.push_back(h);
    stepsLeft_ = kLeastSteps + kStepsPerEdge * edges_.size();
    numberVertices();
    listEdgesOfVertices();
    findVerticesOnEdges();
  }

  std::size_t size() const { return edges_.size(); }
  std::uint32_t halfedge(std::size_t edge) const { return edges_[edge]; }

  /// The T-junctions of an edge, in the order along it.
  void junctionsOf(std::uint32_t edge, std::vector<Junction>& junctions) {
    junctions.clear();
    const std::uint32_t a = startOf(triangles_, edges_[edge]), b = endOf(triangles_, edges_[edge]);
    stamp_[number_[a]] = stamp_[number_[b]] = edge;
    for (std::uint32_t i = first_[edge]; i < first_[edge + 1]; ++i) stamp_[number_[on_[i].vertex]] = edge;
    for (std::uint32_t i = first_[edge]; i < first_[edge + 1]; ++i)
      if (continuesAt(edge, on_[i].vertex)) junctions.push_back(on_[i]);
    std::sort(junctions.begin(), junctions.end(), [](const Junction& x, const Junction& y) {
      return x.along != y.along ? x.along < y.along : x.vertex < y.vertex;
    });
  }

 private:
  /// Numbers the vertices of open edges in the order of their indices.
  void numberVertices() {
    number_.assign(points_.size(), kNone);
    for (const std::uint32_t h : edges_) number_[startOf(triangles_, h)] = number_[endOf(triangles_, h)] = 0;
    for (std::uint32_t v = 0; v < number_.size(); ++v) {
      if (number_[v] == kNone) continue;
      number_[v] = static_cast<std::uint32_t>(vertices_.size());
      vertices_.push_back(v);
    }
    stamp_.assign(vertices_.size(), kNone);
  }

  void listEdgesOfVertices() {
    edgesAt_ = Buckets(vertices_.size(), [&](const auto& add) {
      for (std::uint32_t e = 0; e < edges_.size(); ++e)
        for (const std::uint32_t v : {startOf(triangles_, edges_[e]), endOf(triangles_, edges_[e])})
          add(number_[v], e);
    });
  }

  void findVerticesOnEdges() {
    const PointTree tree(points_, vertices_);
    first_.reserve(edges_.size() + 1);
    first_.push_back(0);
    for (const std::uint32_t h : edges_) {
      const TriangleIndices& own = triangles_[h / 3];
      const glm::dvec3 &a = points_[startOf(triangles_, h)], &b = points_[endOf(triangles_, h)];
      const double square = glm::dot(b - a, b - a);
      tree.forEachNear(a, b, tolerance_, stepsLeft_, [&](std::uint32_t v) {
        if (v == own[0] || v == own[1] || v == own[2]) return;
        const double along = glm::dot(points_[v] - a, b - a) / square;
        if (along > 0.0 && along < 1.0 && glm::distance(points_[v], a + along * (b - a)) <= tolerance_)
          on_.push_back({v, along});
      });
      std::sort(on_.begin() + first_.back(), on_.end(),
                [](const Junction& x, const Junction& y) { return x.vertex < y.vertex; });
      first_.push_back(static_cast<std::uint32_t>(on_.size()));
    }
  }

  bool isOn(std::uint32_t edge, std::uint32_t vertex) const {
    const auto last = on_.begin() + first_[edge + 1];
    const auto found = std::lower_bound(on_.begin() + first_[edge], last, vertex,
                                        [](const Junction& j, std::uint32_t v) { return j.vertex < v; });
    return found != last && found->vertex == vertex;
  }

  /// Whether another open edge runs along this one from a vertex on it. The vertices on it and its ends are
  /// stamped with it.
  bool continuesAt(std::uint32_t edge, std::uint32_t vertex) {
    const std::uint32_t h = edges_[edge];
    for (const std::uint32_t other : edgesAt_[number_[vertex]]) {
      if (stepsLeft_ == 0) return false;
      --stepsLeft_;
      const std::uint32_t g = edges_[other];
      if (g / 3 == h / 3) continue;
      const std::uint32_t start = startOf(triangles_, g), end = endOf(triangles_, g);
      // Two segments run along each other if two different ends are common to both.
      const bool along = stamp_[number_[start == vertex ? end : start]] == edge ||
                         isOn(other, startOf(triangles_, h)) || isOn(other, endOf(triangles_, h));
      if (along && !areFolded(h, g)) return true;
    }
    return false;
  }

  /// m, from the line of an open edge to the third corner of its face.
  glm::dvec3 reachOf(std::uint32_t h) const {
    const glm::dvec3& a = points_[startOf(triangles_, h)];
    const glm::dvec3 along = points_[endOf(triangles_, h)] - a,
                     apex = points_[triangles_[h / 3][(h % 3 + 2) % 3]] - a;
    return apex - glm::dot(apex, along) / glm::dot(along, along) * along;
  }

  /// Whether the faces of two open edges that run along each other lie on each other, as those of a plate
  /// without thickness do.
  bool areFolded(std::uint32_t h, std::uint32_t g) const {
    const glm::dvec3 p = reachOf(h), q = reachOf(g);
    const double high = glm::length(p), low = glm::length(q);
    if (std::min(high, low) <= kReaching * tolerance_ || glm::dot(p, q) <= 0.0) return false;
    return glm::length(glm::cross(p, q)) <= kFolded * tolerance_ * std::max(high, low);
  }

  const std::vector<glm::dvec3>& points_;
  const std::vector<TriangleIndices>& triangles_;
  double tolerance_;
  std::size_t stepsLeft_ = 0;
  std::vector<std::uint32_t> edges_;     // E halfedges
  std::vector<std::uint32_t> vertices_;  // of open edges, ascending
  std::vector<std::uint32_t> number_;    // V: place in vertices_, or kNone
  Buckets edgesAt_;                      // open edges of each of vertices_
  std::vector<std::uint32_t> first_;     // E + 1, into on_
  std::vector<Junction> on_;             // vertices on each edge, ascending
  std::vector<std::uint32_t> stamp_;     // by place in vertices_: the edge that it is on
};

/// Cuts triangles at vertices on their edges.
class Cutter {
 public:
  Cutter(const std::vector<TriangleIndices>& triangles, std::vector<SplitTriangle>& out)
      : triangles_(triangles), out_(out) {}

  void keep(std::uint32_t t) {
    out_.push_back({t, triangles_[t], {corner(0).weights, corner(1).weights, corner(2).weights}});
  }

  /// Cuts triangle t at the junctions of its edges. All pieces have a part of an edge or a corner of the
  /// parent on each side, so that none is flat unless the parent is.
  void cut(std::uint32_t t, const std::array<std::vector<Junction>, 3>& junctions) {
    parent_ = t;
    for (int e = 0; e < 3; ++e) {
      chains_[e].clear();
      for (const Junction& j : junctions[e]) {
        Corner on{j.vertex, glm::dvec3(0.0)};
        on.weights[e] = 1.0 - j.along;
        on.weights[(e + 1) % 3] = j.along;
        chains_[e].push_back(on);
      }
    }
    const Corner a = own(0), b = own(1), c = own(2);
    if (!chains_[0].empty()) {
      fan(chains_[0].front(), c, chains_[2], a);
      for (std::size_t i = 0; i + 1 < chains_[0].size(); ++i) add(chains_[0][i], chains_[0][i + 1], c);
      fan(chains_[0].back(), b, chains_[1], c);
    } else if (!chains_[1].empty()) {
      const Corner last = chains_[1].back();
      chains_[1].pop_back();
      fan(a, b, chains_[1], last);
      fan(last, c, chains_[2], a);
    } else {
      fan(b, c, chains_[2], a);
    }
  }

 private:
  struct Corner {
    std::uint32_t vertex = 0;
    glm::dvec3 weights{0.0};
  };

  static Corner corner(int i) {
    Corner result;
    result.weights[i] = 1.0;
    return result;
  }
  Corner own(int i) const { return {triangles_[parent_][static_cast<std::size_t>(i)], corner(i).weights}; }

  /// The triangles between an apex and a chain of corners.
  void fan(const Corner& apex, const Corner& from, const std::vector<Corner>& chain, const Corner& to) {
    Corner before = from;
    for (const Corner& here : chain) {
      add(apex, before, here);
      before = here;
    }
    add(apex, before, to);
  }

  /// A vertex that lies on two edges, near their common corner, closes the corner.
  void add(const Corner& a, const Corner& b, const Corner& c) {
    if (a.vertex == b.vertex || b.vertex == c.vertex || c.vertex == a.vertex) return;
    out_.push_back({parent_, {a.vertex, b.vertex, c.vertex}, {a.weights, b.weights, c.weights}});
  }

  const std::vector<TriangleIndices>& triangles_;
  std::vector<SplitTriangle>& out_;
  std::uint32_t parent_ = 0;
  std::array<std::vector<Corner>, 3> chains_;
};

}  // namespace

EdgeSplits splitAtJunctions(const std::vector<glm::dvec3>& points,
                            const std::vector<TriangleIndices>& triangles, const EdgePairs& pairs,
                            double tolerance) {
  EdgeSplits splits;
  if (pairs.openEdges == 0) return splits;
  ASSERT(pairs.across.size() == 3 * triangles.size());
  OpenEdges edges(points, triangles, pairs, tolerance);
  Cutter cutter(triangles, splits.triangles);
  std::array<std::vector<Junction>, 3> junctions;
  std::uint32_t next = 0;  // the first triangle that is not in the result yet
  // Open edges are in the order of their halfedges, so those of one triangle follow each other.
  for (std::size_t e = 0; e < edges.size();) {
    const std::uint32_t t = edges.halfedge(e) / 3;
    std::size_t found = 0;
    for (auto& list : junctions) list.clear();
    for (; e < edges.size() && edges.halfedge(e) / 3 == t; ++e) {
      std::vector<Junction>& list = junctions[edges.halfedge(e) % 3];
      edges.junctionsOf(static_cast<std::uint32_t>(e), list);
      found += list.size();
    }
    if (found == 0) continue;
    if (splits.junctions == 0) splits.triangles.reserve(triangles.size() + edges.size());
    splits.junctions += found;
    while (next < t) cutter.keep(next++);
    cutter.cut(next++, junctions);
  }
  if (splits.junctions == 0) return splits;
  while (next < triangles.size()) cutter.keep(next++);
  return splits;
}

}  // namespace tandem::assets
