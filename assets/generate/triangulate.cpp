#include "assets/generate/triangulate.h"

#include <algorithm>
#include <cstddef>

#include <glm/geometric.hpp>

#include "assets/base/assert.h"

namespace tandem::generate {
namespace {

using Polygon = std::vector<glm::dvec2>;

/// Twice the signed area of a triangle.
double area(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

bool crosses(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c, const glm::dvec2& d) {
  if (a == c || a == d || b == c || b == d) return false;
  return area(a, b, c) * area(a, b, d) <= 0.0 && area(c, d, a) * area(c, d, b) <= 0.0;
}

bool crossesAny(const glm::dvec2& a, const glm::dvec2& b, const Polygon& polygon) {
  for (std::size_t i = 0; i < polygon.size(); ++i)
    if (crosses(a, b, polygon[i], polygon[(i + 1) % polygon.size()])) return true;
  return false;
}

/// Whether p lies within the interior angle of the polygon at corner i. This distinguishes the copies of a
/// corner that has two bridges.
bool isWithinAngle(const Polygon& polygon, std::size_t i, const glm::dvec2& p) {
  const glm::dvec2& previous = polygon[(i + polygon.size() - 1) % polygon.size()];
  const glm::dvec2 &corner = polygon[i], &next = polygon[(i + 1) % polygon.size()];
  const bool leftOfOut = area(corner, next, p) > 0.0, leftOfIn = area(previous, corner, p) > 0.0;
  return area(previous, corner, next) >= 0.0 ? leftOfOut && leftOfIn : leftOfOut || leftOfIn;
}

/// Joins a hole to the polygon by the shortest bridge from the hole's rightmost corner. Holes further right
/// are joined before, so that a free view to the right always ends at the polygon.
void bridge(Polygon& polygon, const Polygon& hole, const std::vector<Polygon>& holes) {
  const auto less = [](const glm::dvec2& a, const glm::dvec2& b) { return a.x < b.x; };
  const auto tip = std::max_element(hole.begin(), hole.end(), less);
  std::size_t best = polygon.size();
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const bool nearer =
        best == polygon.size() || glm::distance(polygon[i], *tip) < glm::distance(polygon[best], *tip);
    if (!nearer || !isWithinAngle(polygon, i, *tip) || crossesAny(polygon[i], *tip, polygon)) continue;
    const auto blocks = [&](const Polygon& other) { return crossesAny(polygon[i], *tip, other); };
    if (std::none_of(holes.begin(), holes.end(), blocks)) best = i;
  }
  ASSERT(best < polygon.size());
  Polygon detour{polygon[best]};
  const auto start = tip - hole.begin();
  for (std::size_t k = 0; k <= hole.size(); ++k)  // clockwise around the hole, back to its tip
    detour.push_back(hole[(static_cast<std::size_t>(start) + hole.size() - k % hole.size()) % hole.size()]);
  polygon.insert(polygon.begin() + static_cast<std::ptrdiff_t>(best), detour.begin(), detour.end());
}

bool isEar(const Polygon& polygon, const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c) {
  return std::none_of(polygon.begin(), polygon.end(), [&](const glm::dvec2& p) {
    if (p == a || p == b || p == c) return false;
    return area(a, b, p) >= 0.0 && area(b, c, p) >= 0.0 && area(c, a, p) >= 0.0;
  });
}

}  // namespace

std::vector<std::array<glm::dvec2, 3>> triangulate(const Polygon& outer, std::vector<Polygon> holes) {
  const auto right = [](const Polygon& hole) {
    double x = hole[0].x;
    for (const glm::dvec2& p : hole) x = std::max(x, p.x);
    return x;
  };
  std::stable_sort(holes.begin(), holes.end(),
                   [&](const Polygon& a, const Polygon& b) { return right(a) > right(b); });
  Polygon polygon = outer;
  for (const Polygon& hole : holes) bridge(polygon, hole, holes);

  std::vector<std::array<glm::dvec2, 3>> triangles;
  while (polygon.size() > 2) {
    std::size_t best = polygon.size();
    double bestQuality = 0.0;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
      const glm::dvec2& a = polygon[(i + polygon.size() - 1) % polygon.size()];
      const glm::dvec2 &b = polygon[i], &c = polygon[(i + 1) % polygon.size()];
      const double sides = glm::dot(b - a, b - a) + glm::dot(c - b, c - b) + glm::dot(a - c, a - c);
      const double quality = area(a, b, c) / sides;
      if (quality <= std::max(bestQuality, 1e-9) || !isEar(polygon, a, b, c)) continue;
      best = i;
      bestQuality = quality;
    }
    ASSERT(best < polygon.size());
    triangles.push_back({polygon[(best + polygon.size() - 1) % polygon.size()], polygon[best],
                         polygon[(best + 1) % polygon.size()]});
    polygon.erase(polygon.begin() + static_cast<std::ptrdiff_t>(best));
  }
  return triangles;
}

}  // namespace tandem::generate
