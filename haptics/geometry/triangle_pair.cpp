#include "haptics/geometry/triangle_pair.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <glm/common.hpp>

namespace tandem::haptics {
namespace {

/// Keeps a pair of points if it is the nearest so far.
void keepNearest(const glm::dvec3& onA, const glm::dvec3& onB, TrianglePairGap& best) {
  const glm::dvec3 path = onA - onB;
  const double square = glm::dot(path, path);
  if (square < best.square) best = {square, onA, onB};
}

/// Keeps the nearest points of the edges p + s u and q + t v where both lie within the edges (Ericson,
/// Real-Time Collision Detection, 5.1.9). Elsewhere an end is nearest, which the tests of corners cover.
/// Any s and t in range name true points of both, so the rounding of nearly parallel edges costs only
/// second-order tightness.
void keepNearestOfEdges(const glm::dvec3& p, const glm::dvec3& u, const glm::dvec3& q, const glm::dvec3& v,
                        TrianglePairGap& best) {
  const glm::dvec3 r = p - q;
  const double uu = glm::dot(u, u), vv = glm::dot(v, v), uv = glm::dot(u, v);
  const double determinant = uu * vv - uv * uv;
  if (!(determinant > 0x1p-50 * uu * vv)) return;
  const double ur = glm::dot(u, r), vr = glm::dot(v, r);
  const double s = (uv * vr - vv * ur) / determinant, t = (uu * vr - uv * ur) / determinant;
  if (s > 0.0 && s < 1.0 && t > 0.0 && t < 1.0) keepNearest(p + u * s, q + v * t, best);
}

/// Flatter than about 1e-3: the nearest point of the face is known only to 1e-5 of its length.
bool isSliver(const Triangle& t) {
  const glm::dvec3 ab = t.b - t.a, ac = t.c - t.a, n = glm::cross(ab, ac);
  return glm::dot(n, n) < 1e-6 * glm::dot(ab, ab) * glm::dot(ac, ac);
}

/// Calls pair(corner, nearest point) for the corners of one triangle and the edges of another that is a
/// sliver: its edges are known exactly.
template <typename Pair>
void pairCornersWithEdges(const std::array<glm::dvec3, 3>& corners, const std::array<glm::dvec3, 3>& sliver,
                          Pair&& pair) {
  for (std::size_t i = 0; i < 3; ++i) {
    const glm::dvec3 &from = sliver[i], path = sliver[(i + 1) % 3] - from;
    const double square = glm::dot(path, path);
    for (const glm::dvec3& corner : corners) {
      const double share = square > 0.0 ? std::clamp(glm::dot(corner - from, path) / square, 0.0, 1.0) : 0.0;
      pair(corner, from + path * share);
    }
  }
}

/// By how much the place where an edge passes through the face of `t` may be off, m. The more slender a
/// triangle, the less its plane is known.
double passageRounding(const glm::dvec3& from, const glm::dvec3& to, const Triangle& t) {
  constexpr double kFlattest = 0x1p-10;
  const glm::dvec3 ab = t.b - t.a, ac = t.c - t.a, bc = t.c - t.b;
  const double longest = std::max({glm::dot(ab, ab), glm::dot(ac, ac), glm::dot(bc, bc)});
  const double flatness = std::max(kFlattest, glm::length(glm::cross(ab, ac)) / longest);
  return 0x1p-44 / flatness * (glm::length(to - from) + glm::length(ab) + glm::length(ac));
}

/// Whether an edge passes through the face of `t`; `best` is then that point. Where the edge passes through
/// its plane beside the face, by more than rounding, that point and the nearest one of the face are kept as a
/// pair of near points.
bool passes(const glm::dvec3& from, const glm::dvec3& to, const Triangle& t, bool edgeOfA,
            TrianglePairGap& best) {
  const double share = pierceShare(from, to, t);
  if (share < 0.0) return false;
  const glm::dvec3 point = from + (to - from) * share, onFace = closestPointOnTriangle(point, t).point;
  if (glm::length(onFace - point) > passageRounding(from, to, t) + 0x1p-50 * glm::length(point)) {
    keepNearest(edgeOfA ? point : onFace, edgeOfA ? onFace : point, best);
    return false;
  }
  best = {0.0, point, point};
  return true;
}

/// Gap between the plane of `facet` and `t`, m; if negative, the shortest displacement that puts `t` on one
/// side.
double planeGap(const Facet& facet, const Triangle& t) {
  const double a = glm::dot(facet.normal, t.a - facet.t.a), b = glm::dot(facet.normal, t.b - facet.t.a),
               c = glm::dot(facet.normal, t.c - facet.t.a);
  return std::max(std::min({a, b, c}), -std::max({a, b, c}));
}

/// The nearest points, or any as near as the root of `enough` (m^2).
TrianglePairGap search(const Triangle& a, const Triangle& b, double enough) {
  const std::array<glm::dvec3, 3> p{a.a, a.b, a.c}, q{b.a, b.b, b.c};
  TrianglePairGap best;
  best.square = HUGE_VAL;
  for (const glm::dvec3& corner : p) keepNearest(corner, closestPointOnTriangle(corner, b).point, best);
  for (const glm::dvec3& corner : q) keepNearest(closestPointOnTriangle(corner, a).point, corner, best);
  if (best.square <= enough) return best;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      keepNearestOfEdges(p[i], p[(i + 1) % 3] - p[i], q[j], q[(j + 1) % 3] - q[j], best);
    }
  }
  if (isSliver(b)) {
    pairCornersWithEdges(p, q,
                         [&](const glm::dvec3& onA, const glm::dvec3& onB) { keepNearest(onA, onB, best); });
  }
  if (isSliver(a)) {
    pairCornersWithEdges(q, p,
                         [&](const glm::dvec3& onB, const glm::dvec3& onA) { keepNearest(onA, onB, best); });
  }
  if (furtherThan(0.0, facetOf(a), facetOf(b))) return best;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t next = (i + 1) % 3;
    if (passes(p[i], p[next], b, true, best) || passes(q[i], q[next], a, false, best)) break;
  }
  return best;
}

}  // namespace

Facet facetOf(const Triangle& t) {
  const glm::dvec3 n = areaVector(t);
  const double length = glm::length(n);
  return {t, length > 0.0 ? n / length : glm::dvec3(0.0), glm::min(t.a, glm::min(t.b, t.c)),
          glm::max(t.a, glm::max(t.b, t.c))};
}

bool furtherThan(double reach, const Facet& a, const Facet& b) {
  const glm::dvec3 gap = glm::max(glm::max(a.low - b.high, b.low - a.high), glm::dvec3(0.0));
  return glm::dot(gap, gap) > reach * reach || planeGap(a, b.t) > reach || planeGap(b, a.t) > reach;
}

double pierceShare(const glm::dvec3& from, const glm::dvec3& to, const Triangle& t) {
  constexpr double kMissed = -1.0;
  const glm::dvec3 normal = areaVector(t);
  const double start = glm::dot(normal, from - t.a), end = glm::dot(normal, to - t.a);
  if ((start > 0.0) == (end > 0.0) && start != 0.0 && end != 0.0) return kMissed;
  if (start == end) return kMissed;
  // Signed volumes of the line with the three edges: equal signs mean that the line passes through the
  // triangle.
  const glm::dvec3 path = to - from, a = t.a - from, b = t.b - from, c = t.c - from;
  const double u = glm::dot(path, glm::cross(b, a)), v = glm::dot(path, glm::cross(c, b)),
               w = glm::dot(path, glm::cross(a, c));
  const bool negative = u <= 0.0 && v <= 0.0 && w <= 0.0, positive = u >= 0.0 && v >= 0.0 && w >= 0.0;
  if (!negative && !positive) return kMissed;
  return std::clamp(start / (start - end), 0.0, 1.0);
}

double standThrough(const Facet& a, const Facet& b) {
  return std::max(0.0, std::min(-planeGap(a, b.t), -planeGap(b, a.t)));
}

TrianglePairGap nearestPoints(const Triangle& a, const Triangle& b) { return search(a, b, 0.0); }

bool comeNear(const Triangle& a, const Triangle& b, double distance) {
  return search(a, b, distance * distance).square <= distance * distance;
}

}  // namespace tandem::haptics
