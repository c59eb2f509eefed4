#include "haptics/geometry/triangle_math.h"

#include <algorithm>
#include <cmath>

#include "haptics/geometry/ball_passage.h"
#include "haptics/geometry/segment.h"

namespace tandem::haptics {
namespace {

/// For triangles without area, whose face regions are empty.
TrianglePoint closestOnEdges(const glm::dvec3& p, const Triangle& t) {
  const glm::dvec3 candidates[3] = {closestPointOnSegment(p, t.a, t.b), closestPointOnSegment(p, t.b, t.c),
                                    closestPointOnSegment(p, t.c, t.a)};
  TrianglePoint best{candidates[0], false};
  for (const glm::dvec3& q : candidates) {
    if (glm::dot(p - q, p - q) < glm::dot(p - best.point, p - best.point)) best.point = q;
  }
  return best;
}

/// For triangles so thin that the signs of their face regions are unreliable. Below a flatness of 1e-10 rad
/// only edges count.
TrianglePoint closestOnSliver(const glm::dvec3& p, const Triangle& t, const glm::dvec3& normal) {
  const glm::dvec3 ab = t.b - t.a, ac = t.c - t.a;
  const double square = glm::dot(normal, normal);
  if (square > 1e-20 * glm::dot(ab, ab) * glm::dot(ac, ac)) {
    const glm::dvec3 foot = p - normal * (glm::dot(normal, p - t.a) / square);
    const bool inside = glm::dot(normal, glm::cross(ab, foot - t.a)) > 0.0 &&
                        glm::dot(normal, glm::cross(t.c - t.b, foot - t.b)) > 0.0 &&
                        glm::dot(normal, glm::cross(-ac, foot - t.c)) > 0.0;
    if (inside) return {foot, true};
  }
  return closestOnEdges(p, t);
}

}  // namespace

TrianglePoint closestPointOnTriangle(const glm::dvec3& p, const Triangle& t) {
  // The Voronoi regions of corners and edges in turn; what remains is that of the face.
  const glm::dvec3 ab = t.b - t.a, ac = t.c - t.a, ap = p - t.a;
  const double d1 = glm::dot(ab, ap), d2 = glm::dot(ac, ap);
  if (d1 <= 0.0 && d2 <= 0.0) return {t.a, false};

  const glm::dvec3 bp = p - t.b;
  const double d3 = glm::dot(ab, bp), d4 = glm::dot(ac, bp);
  if (d3 >= 0.0 && d4 <= d3) return {t.b, false};

  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 && d1 - d3 > 0.0) return {t.a + ab * (d1 / (d1 - d3)), false};

  const glm::dvec3 cp = p - t.c;
  const double d5 = glm::dot(ab, cp), d6 = glm::dot(ac, cp);
  if (d6 >= 0.0 && d5 <= d6) return {t.c, false};

  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 && d2 - d6 > 0.0) return {t.a + ac * (d2 / (d2 - d6)), false};

  const double va = d3 * d6 - d5 * d4;
  const double along = (d4 - d3) + (d5 - d6);
  if (va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 && along > 0.0) {
    return {t.b + (t.c - t.b) * ((d4 - d3) / along), false};
  }
  const double sum = va + vb + vc;
  // The sum should be the squared length of ab x ac. For a sliver far from the point, rounding swamps it.
  const glm::dvec3 normal = glm::cross(ab, ac);
  const double square = glm::dot(normal, normal);
  if (std::abs(sum - square) > 1e-6 * square) return closestOnSliver(p, t, normal);
  return {t.a + ab * (vb / sum) + ac * (vc / sum), true};
}

glm::dvec3 contactNormal(const glm::dvec3& p, const Triangle& t, const TrianglePoint& closest) {
  const glm::dvec3 offset = p - closest.point;
  const double distance = glm::length(offset);
  if (!closest.onFace && distance > 0.0) return offset / distance;
  const glm::dvec3 normal = areaVector(t);
  const double length = glm::length(normal);
  if (!(length > 0.0)) return distance > 0.0 ? offset / distance : glm::dvec3(0.0, 0.0, 1.0);
  return glm::dot(normal, offset) < 0.0 ? -normal / length : normal / length;
}

bool sweepBall(const glm::dvec3& from, const glm::dvec3& motion, double radius, double tolerance,
               const Triangle& triangle, BallHit& hit) {
  const auto closest = [&](const glm::dvec3& p) { return closestPointOnTriangle(p, triangle); };
  return sweepPast(
      BallPassage<decltype(closest)>{from, motion, radius, glm::length(motion), triangle, closest}, tolerance,
      hit);
}

}  // namespace tandem::haptics
