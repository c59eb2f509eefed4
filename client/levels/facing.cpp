#include "client/levels/facing.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include <glm/geometric.hpp>

namespace tandem::client {
namespace {

constexpr std::size_t kRays = 256;        // along the longer side of the box, in each direction
constexpr double kThin = 2e-5;            // of the diagonal: what no picture shows
constexpr glm::dvec2 kFirst(0.43, 0.61);  // of a cell; off the lines on which meshes have their symmetry

/// Where a ray meets a triangle.
struct Crossing {
  std::uint32_t ray = 0;
  std::int32_t enters = 0;  // 1, or -1 where the ray leaves
  double depth = 0.0;       // m, along the ray
};

/// Twice the area of the triangle a, b, p; of b, a, p exactly the negative.
double side(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& p) {
  const bool swapped = b.x < a.x || (b.x == a.x && b.y < a.y);
  const glm::dvec2 from = swapped ? b : a, to = swapped ? a : b;
  const double area = (to.x - from.x) * (p.y - from.y) - (to.y - from.y) * (p.x - from.x);
  return swapped ? -area : area;
}

/// The rays along one axis through a mesh.
class Rays {
 public:
  Rays(const RenderMesh& mesh, const assets::Bounds& bounds, glm::length_t axis)
      : axis_(axis), low_(across(bounds.min)) {
    const glm::dvec2 extent = across(bounds.max) - low_;
    cell_ = std::max({extent.x, extent.y, 1e-300}) / static_cast<double>(kRays);
    for (std::size_t i = 0; i < mesh.indices.size(); i += 3)
      meet({glm::dvec3(mesh.vertices[mesh.indices[i]].position),
            glm::dvec3(mesh.vertices[mesh.indices[i + 1]].position),
            glm::dvec3(mesh.vertices[mesh.indices[i + 2]].position)});
    sortByRay();
  }

  /// Whether a ray is for longer than `thin` where it has left more often than it has entered.
  bool findInsideOut(double thin) const {
    int entered = 0;
    for (std::size_t i = 0; i + 1 < crossings_.size(); ++i) {
      const Crossing &here = crossings_[i], &next = crossings_[i + 1];
      entered += here.enters;
      if (here.ray != next.ray)
        entered = 0;
      else if (entered < 0 && next.depth - here.depth > thin)
        return true;
    }
    return false;
  }

 private:
  glm::dvec2 across(const glm::dvec3& p) const { return {p[(axis_ + 1) % 3], p[(axis_ + 2) % 3]}; }

  void meet(const std::array<glm::dvec3, 3>& corners) {
    std::array<glm::dvec2, 3> p;
    for (std::size_t k = 0; k < 3; ++k) p[k] = (across(corners[k]) - low_) / cell_ - kFirst;
    const double area = side(p[0], p[1], p[2]);
    if (area == 0.0) return;
    const glm::dvec2 from = glm::ceil(glm::min(glm::min(p[0], p[1]), p[2]));
    const glm::dvec2 to = glm::floor(glm::max(glm::max(p[0], p[1]), p[2]));
    const double facing = area > 0.0 ? 1.0 : -1.0;
    for (double y = from.y; y <= to.y; ++y)
      for (double x = from.x; x <= to.x; ++x) {
        const double a = facing * side(p[1], p[2], {x, y}), b = facing * side(p[2], p[0], {x, y}),
                     c = facing * side(p[0], p[1], {x, y});
        if (a <= 0.0 || b <= 0.0 || c <= 0.0) continue;
        const double depth =
            (a * corners[0][axis_] + b * corners[1][axis_] + c * corners[2][axis_]) / (a + b + c);
        crossings_.push_back({static_cast<std::uint32_t>(y) * static_cast<std::uint32_t>(kRays) +
                                  static_cast<std::uint32_t>(x),
                              area > 0.0 ? -1 : 1, depth});
      }
  }

  /// Sorts the crossings by ray, by counting, and the few of each ray by their depth.
  void sortByRay() {
    std::vector<std::uint32_t> first(kRays * kRays + 1, 0);
    for (const Crossing& crossing : crossings_) ++first[crossing.ray + 1];
    for (std::size_t ray = 0; ray < kRays * kRays; ++ray) first[ray + 1] += first[ray];
    std::vector<Crossing> sorted(crossings_.size());
    std::vector<std::uint32_t> next = first;
    for (const Crossing& crossing : crossings_) sorted[next[crossing.ray]++] = crossing;
    for (std::size_t ray = 0; ray < kRays * kRays; ++ray)
      std::sort(sorted.begin() + first[ray], sorted.begin() + first[ray + 1],
                [](const Crossing& a, const Crossing& b) { return a.depth < b.depth; });
    crossings_ = std::move(sorted);
  }

  glm::length_t axis_;
  glm::dvec2 low_;
  double cell_ = 1.0;
  std::vector<Crossing> crossings_;
};

}  // namespace

bool facesOutward(const assets::Mesh& exact, const RenderMesh& level) {
  if (!exact.closed) return false;
  assets::Bounds bounds;
  for (const RenderVertex& vertex : level.vertices) bounds.include(glm::dvec3(vertex.position));
  const double thin = kThin * glm::length(bounds.max - bounds.min);
  for (glm::length_t axis = 0; axis < 3; ++axis)
    if (Rays(level, bounds, axis).findInsideOut(thin)) return false;
  return true;
}

}  // namespace tandem::client
