#pragma once

// The swept test of a ball against one convex face, by whatever finds the face's nearest point. For
// triangle_math.cpp and cut_triangle.cpp only.

#include <algorithm>
#include <cmath>

#include "haptics/geometry/triangle_math.h"

namespace tandem::haptics {

/// The gap between a moving ball and a triangle at one instant, and its rate. A convex function of t lies
/// above each of its tangents.
struct BallGap {
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
  void narrow(const BallGap& before) {
    const double span = t - before.t, error = 2.0 * std::max(rounding, before.rounding);
    const double highest = slope + noise, least = std::min(highest, (gap - before.gap - error) / span);
    if (least <= slope - noise) return;
    slope = 0.5 * (highest + least);
    noise = 0.5 * (highest - least);
  }
};

/// A ball that moves past a triangle or a convex part of one; `closest(p)` is its point nearest to p.
template <typename Closest>
struct BallPassage {
  const glm::dvec3 &from, &motion;
  const double radius, length;
  const Triangle& triangle;
  const Closest& closest;

  BallGap tangentAt(double t) const {
    const glm::dvec3 p = from + motion * t;
    BallGap tangent;
    tangent.t = t;
    tangent.closest = closest(p);
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
  double shortStep(const BallGap& tangent, double last) const {
    const double afar = 16.0 * std::max(tangent.gap + radius, tangent.rounding) / length;
    const double fall = tangent.noise - tangent.slope;
    return std::max(afar, std::min(16.0 * last, 0.5 * tangent.gap / fall));
  }
};

/// sweepBall() of triangle_math.h for such a passage.
template <typename Closest>
bool sweepPast(const BallPassage<Closest>& passage, double tolerance, BallHit& hit) {
  // A miss usually takes one round, a hit three. Stopping early reports a contact too soon, which is the safe
  // side.
  constexpr int kMaxRounds = 40;
  const double clear = 0.5 * tolerance;
  BallGap left = passage.tangentAt(0.0), right;
  double step = 0.0;
  bool endKnown = false;   // `right` is the tangent at the end of the motion or before
  bool bracketed = false;  // the gap is open at `right` and grows there, but may have closed before
  for (int round = 0;; ++round) {
    if (!(left.slope < left.noise)) return false;
    if (left.slope >= -left.noise && round < kMaxRounds) {
      // Beside an edge or corner the ball steps on until the gap is clear of rounding or its trend is known.
      step = passage.shortStep(left, step);
      if (!(left.t + step < hit.t)) return false;
      BallGap later = passage.tangentAt(left.t + step);
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
      const BallGap middle = passage.tangentAt(meet);
      bracketed = middle.gap > clear;
      if (bracketed) (middle.slope < 0.0 ? left : right) = middle;
    }
    if (left.next() > hit.t) return false;
    left = passage.tangentAt(left.next());
  }
}

}  // namespace tandem::haptics
