#include "haptics/measure/depth_model.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "assets/base/assert.h"
#include "assets/mesh/mesh_analysis.h"
#include "haptics/geometry/segment.h"

namespace tandem::haptics {
namespace {

using assets::kNone;

constexpr double kSharp = 0.5;          // rad, for the welding only: the flags are not read here
constexpr std::size_t kMaxBorder = 64;  // corners of a facet; a larger facet keeps its triangles
constexpr std::array<glm::dvec3, 3> kRays{
    // Faces and edges of a part are unlikely to have these directions.
    glm::dvec3{0.4827134, 0.6193018, 0.6194272}, glm::dvec3{-0.7071823, 0.1293711, -0.6950937},
    glm::dvec3{0.2313971, -0.8811737, 0.4123391}};

double distanceToSegment(const glm::dvec3& p, const glm::dvec3& a, const glm::dvec3& b) {
  return glm::length(p - closestPointOnSegment(p, a, b));
}

assets::Mesh welded(const assets::Mesh& mesh) {
  assets::TriangleSoup soup{mesh.positions, mesh.triangles, mesh.triangleMaterial, {}, {}};
  soup.triangleMaterial.resize(soup.triangles.size(), 0);
  return assets::analyseMesh(std::move(soup), kSharp).mesh;
}

}  // namespace

/// Finds the facets and ridges of a mesh with topology.
class DepthModelBuilder {
 public:
  DepthModelBuilder(const assets::Mesh& mesh, DepthModel& model)
      : mesh_(mesh), model_(model), tolerance_(model.tolerance()) {}

  void run() {
    ASSERT(mesh_.neighbours.size() == mesh_.triangles.size());
    growPatches();
    findBorders();
    chainBorders();
    addFacets();
    addRidges();
  }

 private:
  struct Border {
    std::uint32_t a, b;  // counter-clockwise in `patch`
    std::uint32_t patch, other;
  };

  glm::dvec3 at(std::uint32_t vertex) const { return mesh_.positions[vertex]; }
  glm::dvec3 areaOf(std::uint32_t t) const {
    const auto& c = mesh_.triangles[t];
    return glm::cross(at(c[1]) - at(c[0]), at(c[2]) - at(c[0]));
  }

  /// Collects connected triangles that are coplanar with the largest among them.
  void growPatches() {
    const auto count = static_cast<std::uint32_t>(mesh_.triangles.size());
    std::vector<double> areas(count);
    for (std::uint32_t t = 0; t < count; ++t) areas[t] = glm::length(areaOf(t));
    std::vector<std::uint32_t> seeds(count);
    std::iota(seeds.begin(), seeds.end(), 0u);
    std::stable_sort(seeds.begin(), seeds.end(),
                     [&](std::uint32_t a, std::uint32_t b) { return areas[a] > areas[b]; });
    patchOf_.assign(count, kNone);
    for (const std::uint32_t seed : seeds) {
      if (patchOf_[seed] != kNone) continue;
      const auto patch = static_cast<std::uint32_t>(patchNormals_.size());
      patchNormals_.push_back(areas[seed] > 0.0 ? areaOf(seed) / areas[seed] : glm::dvec3(0.0));
      growFrom(seed, patch);
    }
  }

  void growFrom(std::uint32_t seed, std::uint32_t patch) {
    const glm::dvec3 normal = patchNormals_[patch], origin = at(mesh_.triangles[seed][0]);
    std::vector<std::uint32_t> open{seed};
    patchOf_[seed] = patch;
    const auto inPlane = [&](std::uint32_t t) {
      for (const std::uint32_t v : mesh_.triangles[t]) {
        if (std::abs(glm::dot(normal, at(v) - origin)) > tolerance_) return false;
      }
      return glm::dot(normal, areaOf(t)) > 0.0;
    };
    while (!open.empty()) {
      const std::uint32_t t = open.back();
      open.pop_back();
      for (const std::uint32_t next : mesh_.neighbours[t]) {
        if (next == kNone || patchOf_[next] != kNone || !inPlane(next)) continue;
        patchOf_[next] = patch;
        open.push_back(next);
      }
    }
  }

  void findBorders() {
    degree_.assign(mesh_.positions.size(), 0);
    edgesOf_.assign(mesh_.positions.size(), {kNone, kNone});
    for (std::uint32_t t = 0; t < mesh_.triangles.size(); ++t) {
      for (std::size_t e = 0; e < 3; ++e) {
        const std::uint32_t next = mesh_.neighbours[t][e];
        const std::uint32_t other = next == kNone ? kNone : patchOf_[next];
        if (other == patchOf_[t]) continue;
        const std::uint32_t a = mesh_.triangles[t][e], b = mesh_.triangles[t][(e + 1) % 3];
        borders_.push_back({a, b, patchOf_[t], other});
        if (next != kNone && next < t) continue;  // the neighbour has counted this edge
        const auto edge = static_cast<std::uint32_t>(borders_.size()) - 1;
        edges_.push_back(edge);
        for (const std::uint32_t v : {a, b}) {
          if (degree_[v] < 2) edgesOf_[v][degree_[v]] = edge;
          ++degree_[v];
        }
      }
    }
  }

  std::uint32_t across(std::uint32_t edge, std::uint32_t vertex) const {
    return borders_[edge].a == vertex ? borders_[edge].b : borders_[edge].a;
  }

  /// Whether the border continues straight at a vertex and nothing else meets there.
  bool goesOn(std::uint32_t v) const {
    if (degree_[v] != 2) return false;
    const glm::dvec3 before = at(across(edgesOf_[v][0], v)), after = at(across(edgesOf_[v][1], v));
    return glm::dot(at(v) - before, after - at(v)) > 0.0 &&
           distanceToSegment(at(v), before, after) <= tolerance_;
  }

  /// Joins collinear border edges to chains; marks the vertices where lines end.
  void chainBorders() {
    isCorner_.assign(mesh_.positions.size(), false);
    for (std::uint32_t v = 0; v < isCorner_.size(); ++v) isCorner_[v] = degree_[v] > 0 && !goesOn(v);
    std::vector<bool> done(borders_.size(), false);
    for (const std::uint32_t edge : edges_) {
      if (done[edge] || (!isCorner_[borders_[edge].a] && !isCorner_[borders_[edge].b])) continue;
      std::uint32_t v = isCorner_[borders_[edge].a] ? borders_[edge].a : borders_[edge].b;
      std::vector<std::uint32_t> chain{v};
      for (std::uint32_t e = edge;;) {
        done[e] = true;
        v = across(e, v);
        chain.push_back(v);
        if (isCorner_[v]) break;
        e = edgesOf_[v][0] == e ? edgesOf_[v][1] : edgesOf_[v][0];
      }
      addLines(chain, 0, chain.size() - 1, edge);
    }
  }

  /// Convex edges and borders; every edge of a surface without an inside.
  bool isRidge(const Border& border) const {
    if (!model_.solid_ || border.other == kNone) return true;
    const glm::dvec3 crossed = glm::cross(patchNormals_[border.patch], patchNormals_[border.other]);
    return glm::dot(crossed, at(border.b) - at(border.a)) > 0.0;
  }

  /// Splits a chain until each line represents its points within the tolerance (Douglas & Peucker 1973).
  void addLines(const std::vector<std::uint32_t>& chain, std::size_t first, std::size_t last,
                std::uint32_t edge) {
    std::size_t worst = first;
    double furthest = tolerance_;
    for (std::size_t i = first + 1; i < last; ++i) {
      const double off = distanceToSegment(at(chain[i]), at(chain[first]), at(chain[last]));
      if (off > furthest) {
        furthest = off;
        worst = i;
      }
    }
    if (worst == first) {
      lines_.emplace_back(chain[first], chain[last], isRidge(borders_[edge]));
      return;
    }
    isCorner_[chain[worst]] = true;
    addLines(chain, first, worst, edge);
    addLines(chain, worst, last, edge);
  }

  std::uint32_t cornerOf(std::uint32_t vertex) {
    if (corners_.empty()) corners_.assign(mesh_.positions.size(), kNone);
    if (corners_[vertex] == kNone) {
      corners_[vertex] = static_cast<std::uint32_t>(model_.surface_.positions.size());
      model_.surface_.positions.push_back(at(vertex));
    }
    return corners_[vertex];
  }

  void addFacets() {
    std::stable_sort(borders_.begin(), borders_.end(), [](const Border& x, const Border& y) {
      return x.patch != y.patch ? x.patch < y.patch : x.a < y.a;
    });
    std::vector<std::vector<std::uint32_t>> outlines(patchNormals_.size());
    for (auto begin = borders_.cbegin(); begin != borders_.cend();) {
      auto end = begin;
      while (end != borders_.cend() && end->patch == begin->patch) ++end;
      outlines[begin->patch] = convexOutline(begin, end);
      begin = end;
    }
    for (std::uint32_t patch = 0; patch < outlines.size(); ++patch) {
      if (!outlines[patch].empty()) addFacet(outlines[patch], patchNormals_[patch]);
    }
    for (std::uint32_t t = 0; t < mesh_.triangles.size(); ++t) {
      if (!outlines[patchOf_[t]].empty()) continue;
      const auto& c = mesh_.triangles[t];
      const glm::dvec3 area = areaOf(t);
      const double size = glm::length(area);
      addFacet({c[0], c[1], c[2]}, size > 0.0 ? area / size : glm::dvec3(0.0));
    }
    model_.facets_.push_back(static_cast<std::uint32_t>(model_.border_.size()));
  }

  /// The corners around a patch if it is a convex polygon without holes; else none.
  std::vector<std::uint32_t> convexOutline(std::vector<Border>::const_iterator begin,
                                           std::vector<Border>::const_iterator end) const {
    std::vector<std::uint32_t> corners;
    auto edge = begin;
    for (auto steps = end - begin; steps > 0; --steps) {
      if (isCorner_[edge->a]) corners.push_back(edge->a);
      const std::uint32_t next = edge->b;
      edge = std::lower_bound(begin, end, next, [](const Border& x, std::uint32_t v) { return x.a < v; });
      if (edge == end || edge->a != next || (edge == begin) != (steps == 1)) return {};
    }
    if (corners.size() < 3 || corners.size() > kMaxBorder) return {};
    const glm::dvec3 normal = patchNormals_[begin->patch];
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const glm::dvec3 a = at(corners[i]), b = at(corners[(i + 1) % corners.size()]);
      const glm::dvec3 c = at(corners[(i + 2) % corners.size()]);
      if (glm::dot(normal, glm::cross(b - a, c - b)) < -tolerance_ * glm::length(c - a)) return {};
    }
    return corners;
  }

  void addFacet(const std::vector<std::uint32_t>& corners, const glm::dvec3& normal) {
    const auto facet = static_cast<std::uint32_t>(model_.facets_.size());
    model_.facets_.push_back(static_cast<std::uint32_t>(model_.border_.size()));
    model_.normals_.push_back(normal);
    for (const std::uint32_t v : corners) model_.border_.push_back(cornerOf(v));
    const std::uint32_t* border = model_.border_.data() + model_.facets_.back();
    for (std::size_t i = 2; i < corners.size(); ++i) {
      model_.surface_.triangles.push_back({border[0], border[i - 1], border[i]});
      model_.facetOf_.push_back(facet);
    }
  }

  void addRidges() {
    for (const Line& line : lines_) {
      if (line.convex) model_.ridges_.push_back({cornerOf(line.from), cornerOf(line.to)});
    }
  }

  struct Line {
    Line(std::uint32_t a, std::uint32_t b, bool isConvex) : from(a), to(b), convex(isConvex) {}
    std::uint32_t from, to;
    bool convex;
  };

  const assets::Mesh& mesh_;
  DepthModel& model_;
  double tolerance_;
  std::vector<std::uint32_t> patchOf_;  // of a triangle
  std::vector<glm::dvec3> patchNormals_;
  std::vector<Border> borders_;        // of every patch, each counter-clockwise in its own patch
  std::vector<std::uint32_t> edges_;   // into borders_: each edge once
  std::vector<std::uint32_t> degree_;  // of a vertex: border edges there
  std::vector<std::array<std::uint32_t, 2>> edgesOf_;
  std::vector<bool> isCorner_;
  std::vector<std::uint32_t> corners_;  // of a vertex: in the model
  std::vector<Line> lines_;
};

DepthModel::DepthModel(const assets::Mesh& mesh) {
  const bool bare = mesh.neighbours.size() != mesh.triangles.size();
  assets::Mesh own;
  if (bare) own = welded(mesh);
  const assets::Mesh& source = bare ? own : mesh;
  solid_ = source.closed;
  size_ = source.triangles.empty() ? 0.0 : glm::length(source.bounds.max - source.bounds.min);
  DepthModelBuilder(source, *this).run();
  surface_.triangleMaterial.assign(surface_.triangles.size(), 0);
  for (const glm::dvec3& p : surface_.positions) {
    surface_.bounds.include(p);
  }
  ASSERT(facetOf_.size() == surface_.triangles.size() && facets_.size() == normals_.size() + 1);
  ASSERT(facets_.back() == border_.size());
  tree_ = std::make_unique<TriangleBvh>(surface_, 1);
  segments_ = std::make_unique<SegmentTree>(surface_);
}

double DepthModel::distanceToFacet(std::uint32_t facet, const glm::dvec3& p) const {
  if (withinFacet(facet, p))
    return std::abs(glm::dot(normals_[facet], p - corners()[border_[facets_[facet]]]));
  double least = 1e300;
  const std::uint32_t begin = facets_[facet], end = facets_[facet + 1];
  for (std::uint32_t i = begin; i < end; ++i) {
    const std::uint32_t next = i + 1 == end ? begin : i + 1;
    least = std::min(least, distanceToSegment(p, corners()[border_[i]], corners()[border_[next]]));
  }
  return least;
}

bool DepthModel::withinFacet(std::uint32_t facet, const glm::dvec3& p) const {
  const glm::dvec3& normal = normals_[facet];
  if (normal == glm::dvec3(0.0)) return false;
  ASSERT(facet + 1 < facets_.size());
  const std::uint32_t begin = facets_[facet], end = facets_[facet + 1];
  for (std::uint32_t i = begin; i < end; ++i) {
    const glm::dvec3 a = corners()[border_[i]], b = corners()[border_[i + 1 == end ? begin : i + 1]];
    if (glm::dot(normal, glm::cross(b - a, p - a)) < 0.0) return false;
  }
  return true;
}

bool DepthModel::inside(const glm::dvec3& p, const MeshPoint& nearest) const {
  if (!solid_) return false;
  if (nearest.onFace) {
    const double height = glm::dot(normals_[facetOf_[nearest.triangle]], p - nearest.point);
    if (height != 0.0) return height < 0.0;
  }
  return inside(p);
}

bool DepthModel::inside(const glm::dvec3& p) const {
  if (!solid_) return false;
  const glm::dvec3 centre = 0.5 * (bounds().min + bounds().max);
  const double reach = 2.0 * (size_ + glm::length(p - centre));
  int votes = 0;
  std::vector<SegmentCrossing> found;
  for (const glm::dvec3& direction : kRays) {
    found.clear();
    crossings(p, p + reach * direction, found);
    int sum = 0;
    for (const SegmentCrossing& c : found) sum += c.sign;
    votes += sum > 0 ? 1 : 0;
  }
  return 2 * votes > static_cast<int>(kRays.size());
}

}  // namespace tandem::haptics
