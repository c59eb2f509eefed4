#include "haptics/triangle_math.h"

#include <algorithm>
#include <cmath>

namespace tandem::haptics {
namespace {

glm::dvec3 closestOnSegment(const glm::dvec3& p, const glm::dvec3& a, const glm::dvec3& b) {
  const glm::dvec3 ab = b - a;
  const double square = glm::dot(ab, ab);
  if (!(square > 0.0)) return a;
  return a + ab * std::clamp(glm::dot(p - a, ab) / square, 0.0, 1.0);
}

/// For triangles of no area, whose face regions are empty.
TrianglePoint closestOnEdges(const glm::dvec3& p, const Triangle& t) {
  const glm::dvec3 candidates[3] = {closestOnSegment(p, t.a, t.b), closestOnSegment(p, t.b, t.c),
                                    closestOnSegment(p, t.c, t.a)};
  TrianglePoint best{candidates[0], false};
  for (const glm::dvec3& q : candidates) {
    if (glm::dot(p - q, p - q) < glm::dot(p - best.point, p - best.point)) best.point = q;
  }
  return best;
}

/// For triangles so thin that the signs of their face regions cannot be trusted. Of one flatter than 1e-10
/// rad nothing but edges is left.
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
  // The sum should be the squared length of ab x ac. Seen from afar, a sliver's is drowned by rounding.
  const glm::dvec3 normal = glm::cross(ab, ac);
  const double square = glm::dot(normal, normal);
  if (std::abs(sum - square) > 1e-6 * square) return closestOnSliver(p, t, normal);
  return {t.a + ab * (vb / sum) + ac * (vc / sum), true};
}

glm::dvec3 contactNormal(const glm::dvec3& p, const Triangle& t, const TrianglePoint& closest) {
  const glm::dvec3 offset = p - closest.point;
  const double distance = glm::length(offset);
  if (!closest.onFace && distance > 0.0) return offset / distance;
  const glm::dvec3 normal = glm::cross(t.b - t.a, t.c - t.a);
  const double length = glm::length(normal);
  if (!(length > 0.0)) return distance > 0.0 ? offset / distance : glm::dvec3(0.0, 0.0, 1.0);
  return glm::dot(normal, offset) < 0.0 ? -normal / length : normal / length;
}

namespace {

/// The gap between a moving ball and a triangle at one instant, and its rate: a convex function of t lies
/// above every one of its tangents.
struct Tangent {
  double t = 0.0;
  double gap = 0.0, slope = 0.0;  // m, m per motion
  TrianglePoint closest;
  glm::dvec3 normal{0.0, 0.0, 0.0};

  double at(double when) const { return gap + slope * (when - t); }
  /// Newton's next guess of when the gap closes; the slope must be negative.
  double next() const { return t - gap / slope; }
};

Tangent tangentAt(double t, const glm::dvec3& from, const glm::dvec3& motion, double radius,
                  const Triangle& triangle) {
  const glm::dvec3 p = from + motion * t;
  Tangent tangent;
  tangent.t = t;
  tangent.closest = closestPointOnTriangle(p, triangle);
  tangent.normal = contactNormal(p, triangle, tangent.closest);
  tangent.gap = glm::dot(p - tangent.closest.point, tangent.normal) - radius;
  tangent.slope = glm::dot(motion, tangent.normal);
  return tangent;
}

}  // namespace

bool sweepBall(const glm::dvec3& from, const glm::dvec3& motion, double radius, double tolerance,
               const Triangle& triangle, BallHit& hit) {
  // Usual: one round for a miss, three for a hit. What stops early reports a contact before its time, which
  // is the safe side.
  constexpr int kMaxRounds = 40;
  const double clear = 0.5 * tolerance;
  Tangent left = tangentAt(0.0, from, motion, radius, triangle), right;
  bool bracketed = false;  // the gap is open at `right` and grows there: has it closed in between?
  for (int round = 0;; ++round) {
    if (!(left.slope < 0.0)) return false;
    if (left.gap <= tolerance || round >= kMaxRounds) {
      hit = {left.t, left.closest.point, left.normal, left.closest.onFace};
      return true;
    }
    if (left.next() > hit.t) return false;
    if (round == 0) {
      right = tangentAt(1.0, from, motion, radius, triangle);
      bracketed = right.gap > clear;
      if (bracketed && right.slope <= 0.0) return false;
    }
    // A graze, such as a ball that slides along its neighbours' plane: Newton's iteration would creep towards
    // a double root. Where the two tangents meet is the least that the gap can be, and where to look next.
    while (bracketed) {
      const double meet = (right.at(0.0) - left.at(0.0)) / (left.slope - right.slope);
      if (!(left.at(meet) <= clear)) return false;
      if (++round >= kMaxRounds || !(meet > left.t && meet < right.t)) break;
      const Tangent middle = tangentAt(meet, from, motion, radius, triangle);
      bracketed = middle.gap > clear;
      if (bracketed) (middle.slope < 0.0 ? left : right) = middle;
    }
    if (left.next() > hit.t) return false;
    left = tangentAt(left.next(), from, motion, radius, triangle);
  }
}

}  // namespace tandem::haptics
