#include "haptics/overlap/intrusion_piece.h"

#include <cmath>
#include <utility>

#include "haptics/geometry/triangle_pair.h"

namespace tandem::haptics {
namespace {

double cross2(const glm::dvec2& a, const glm::dvec2& b) { return a.x * b.y - a.y * b.x; }

/// Shares of p's foot on the triangle's plane; nothing if it has no area.
std::optional<glm::dvec2> sharesOf(const Triangle& t, const glm::dvec3& p) {
  const glm::dvec3 u = t.b - t.a, v = t.c - t.a, w = p - t.a;
  const double uu = glm::dot(u, u), uv = glm::dot(u, v), vv = glm::dot(v, v);
  const double determinant = uu * vv - uv * uv;
  if (!(determinant > 0.0)) return {};
  const double wu = glm::dot(w, u), wv = glm::dot(w, v);
  return glm::dvec2((vv * wu - uv * wv) / determinant, (uu * wv - uv * wu) / determinant);
}

}  // namespace

Place Piece::at(const glm::dvec3& cornerShares) const {
  Place place{glm::dvec3(0.0), glm::dvec2(0.0)};
  for (int i = 0; i < 3; ++i) {
    const Place& corner = corners[static_cast<std::size_t>(i)];
    if (cornerShares[i] == 1.0) return corner;
    place.point += cornerShares[i] * corner.point;
    place.shares += cornerShares[i] * corner.shares;
  }
  return place;
}

std::optional<Crossing> crossingOf(const Triangle& own, const Triangle& other) {
  const std::array<glm::dvec3, 3> p{own.a, own.b, own.c}, q{other.a, other.b, other.c};
  std::array<glm::dvec3, 6> points;
  std::size_t count = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const double onOwn = pierceShare(p[i], p[(i + 1) % 3], other);
    if (onOwn >= 0.0) points[count++] = p[i] + (p[(i + 1) % 3] - p[i]) * onOwn;
    const double onOther = pierceShare(q[i], q[(i + 1) % 3], own);
    if (onOther >= 0.0) points[count++] = q[i] + (q[(i + 1) % 3] - q[i]) * onOther;
  }
  std::pair<std::size_t, std::size_t> ends{0, 0};
  double longest = 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t j = i + 1; j < count; ++j) {
      const double square = glm::dot(points[i] - points[j], points[i] - points[j]);
      if (square > longest) longest = square, ends = {i, j};
    }
  }
  if (!(longest > 0.0)) return {};
  const std::optional<glm::dvec2> from = sharesOf(own, points[ends.first]),
                                  to = sharesOf(own, points[ends.second]);
  if (!from || !to) return {};
  return Crossing{*from, *to};
}

double shareWithin(const Crossing& crossing, const Piece& piece) {
  constexpr double kBorder = 1e-9;
  const glm::dvec2 &a = piece.corners[0].shares, &b = piece.corners[1].shares, &c = piece.corners[2].shares;
  const double area = cross2(b - a, c - a);
  if (area == 0.0) return 0.0;
  double first = 0.0, last = 1.0;
  for (const auto& [from, to] : {std::pair{a, b}, std::pair{b, c}, std::pair{c, a}}) {
    const double start = cross2(to - from, crossing.from - from) / area - kBorder,
                 end = cross2(to - from, crossing.to - from) / area - kBorder;
    if (start < 0.0 && end < 0.0) return 0.0;
    if (start < 0.0) first = std::max(first, start / (start - end));
    if (end < 0.0) last = std::min(last, start / (start - end));
  }
  return std::max(0.0, last - first);
}

Heights heightsOver(const Crossing& line, const Piece& piece) {
  Heights heights;
  double largest = 0.0;
  for (std::size_t i = 0; i < 3; ++i) {
    heights[i] = cross2(line.to - line.from, piece.corners[i].shares - line.from);
    largest = std::max(largest, std::abs(heights[i]));
  }
  for (double& height : heights)
    if (std::abs(height) <= 1e-12 * largest) height = 0.0;
  return heights;
}

std::optional<Heights> heightsOverSide(const Triangle& facet, const Piece& piece) {
  constexpr double kSmall = 0.25, kHardly = 0.01;
  const std::array<glm::dvec3, 3> q{facet.a, facet.b, facet.c};
  const double longest = piece.longest();
  const double facetLongest =
      std::max({glm::length(q[1] - q[0]), glm::length(q[2] - q[1]), glm::length(q[0] - q[2])});
  if (facetLongest < kSmall * longest) return {};
  const glm::dvec3 normal = areaVector(facet);
  std::optional<Heights> chosen;
  double most = kHardly * longest;
  for (std::size_t e = 0; e < 3; ++e) {
    const glm::dvec3 outwards = glm::cross(q[(e + 1) % 3] - q[e], normal);
    const double length = glm::length(outwards);
    if (!(length > 0.0)) return {};
    Heights heights;
    for (std::size_t i = 0; i < 3; ++i)
      heights[i] = glm::dot(outwards, piece.corners[i].point - q[e]) / length;
    const double less = std::min(std::max({heights[0], heights[1], heights[2]}),
                                 -std::min({heights[0], heights[1], heights[2]}));
    if (less <= most) continue;
    most = less;
    chosen = heights;
  }
  return chosen;
}

}  // namespace tandem::haptics
