#include "haptics/geometry/triangle_math.h"

#include <algorithm>
#include <cmath>

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

namespace {

/// The gap between a moving ball and a triangle at one instant, and its rate. A convex function of t lies
/// above each of its tangents.
struct Tangent {
  double t = 0.0;
  double gap = 0.0, slope = 0.0;  // m, m per motion
  double noise = 0.0;             // m per motion: rounding error of the slope
  double rounding = 0.0;          // m: of the coordinates
  TrianglePoint closest;
  glm::dvec3 normal{0.0, 0.0, 0.0};

  /// Lower bound of the gap at another time.
  double at(double when) const { return gap + slope * (when - t) - noise * std::abs(when - t); }
  /// Newton's next estimate of the closing time, never late; the slope must be negative.
  double next() const { return t - gap / (slope - noise); }

  /// Raises the slope to that of the chord from an earlier instant, because the slope of a convex function
  /// only grows.
  void narrow(const Tangent& before) {
    const double span = t - before.t, error = 2.0 * std::max(rounding, before.rounding);
    const double highest = slope + noise, least = std::min(highest, (gap - before.gap - error) / span);
    if (least <= slope - noise) return;
    slope = 0.5 * (highest + least);
    noise = 0.5 * (highest - least);
  }
};

/// A ball that moves past a triangle.
struct Passage {
  const glm::dvec3 &from, &motion;
  const double radius, length;
  const Triangle& triangle;

  Tangent tangentAt(double t) const {
    const glm::dvec3 p = from + motion * t;
    Tangent tangent;
    tangent.t = t;
    tangent.closest = closestPointOnTriangle(p, triangle);
    tangent.normal = contactNormal(p, triangle, tangent.closest);
    const double distance = glm::dot(p - tangent.closest.point, tangent.normal);
    tangent.gap = distance - radius;
    tangent.slope = glm::dot(motion, tangent.normal);
    if (!tangent.closest.onFace) {
      // The direction from an edge or corner, over a distance that is little more than a rounding error.
      const glm::dvec3 size = glm::abs(p) + glm::abs(tangent.closest.point);
      tangent.rounding = 0x1p-50 * (size.x + size.y + size.z);
      tangent.noise = length * tangent.rounding / std::max(distance, tangent.rounding);
    }
    return tangent;
  }

  /// Fraction of the motion in which a gap whose slope is noise certainly stays open: it closes by a few
  /// rounding errors, or by at most half. `last` is the previous step, from which the slope was narrowed. The
  /// slope must be smaller than its noise.
  double shortStep(const Tangent& tangent, double last) const {
    const double afar = 16.0 * std::max(tangent.gap + radius, tangent.rounding) / length;
    const double fall = tangent.noise - tangent.slope;
    return std::max(afar, std::min(16.0 * last, 0.5 * tangent.gap / fall));
  }
};

}  // namespace

bool sweepBall(const glm::dvec3& from, const glm::dvec3& motion, double radius, double tolerance,
               const Triangle& triangle, BallHit& hit) {
  // A miss usually takes one round, a hit three. Stopping early reports a contact too soon, which is the safe
  // side.
  constexpr int kMaxRounds = 40;
  const double clear = 0.5 * tolerance;
  const Passage passage{from, motion, radius, glm::length(motion), triangle};
  Tangent left = passage.tangentAt(0.0), right;
  double step = 0.0;
  bool endKnown = false;   // `right` is the tangent at the end of the motion or before
  bool bracketed = false;  // the gap is open at `right` and grows there, but may have closed before
  for (int round = 0;; ++round) {
    if (!(left.slope < left.noise)) return false;
    if (left.slope >= -left.noise && round < kMaxRounds) {
      // Beside an edge or corner the ball steps on until the gap is clear of rounding or its trend is known.
      step = passage.shortStep(left, step);
      if (!(left.t + step < hit.t)) return false;
      Tangent later = passage.tangentAt(left.t + step);
      later.narrow(left);
      left = later;
      continue;
    }
    step = 0.0;
    if (left.gap <= tolerance || round >= kMaxRounds) {
      hit = {left.t, left.closest.point, left.normal, left.closest.onFace};
      return true;
    }
    if (left.next() > hit.t) return false;
    if (!endKnown) {
      endKnown = true;
      right = passage.tangentAt(1.0);
      bracketed = right.gap > clear;
      if (bracketed && right.slope <= 0.0) return false;
    }
    // A graze, such as a ball that slides along its neighbours' plane: Newton's iteration would creep towards
    // a double root. The intersection of the two tangents bounds the least gap, and is the next point to
    // evaluate.
    while (bracketed) {
      const double meet =
          (right.gap - right.slope * right.t - left.gap + left.slope * left.t) / (left.slope - right.slope);
      if (!(std::max(left.at(meet), right.at(meet)) <= clear)) return false;
      if (++round >= kMaxRounds || !(meet > left.t && meet < right.t)) break;
      const Tangent middle = passage.tangentAt(meet);
      bracketed = middle.gap > clear;
      if (bracketed) (middle.slope < 0.0 ? left : right) = middle;
    }
    if (left.next() > hit.t) return false;
    left = passage.tangentAt(left.next());
  }
}

}  // namespace tandem::haptics
