#pragma once

// Float filter for four triangles at once: a lower bound of their distance from a moving point. Triangles
// that pass the filter are tested exactly in double, so results never depend on it.
//
// For every unit vector u, the distance of a point x to a triangle with corners v_i is at least
//     min_i u . (x - v_i),
// because u separates them. The bound holds for any u, and is tight where u points from the triangle's
// nearest point to x. Only the rounding of that sum needs an allowance; slivers and wrong regions cost only
// tightness.

#include "haptics/base/simd4.h"

namespace tandem::haptics {

/// Corners of four triangles, relative to the moving point's start, m.
struct Triangles4 {
  Vec4 a, b, c;
};

/// dist(from + t * motion, triangle) >= distance + t * slope for every t, in exact arithmetic, up to `error`.
struct DistanceBound4 {
  Float4 distance, slope, error;  // m, m per motion, m
};

namespace filter {

/// The point of a segment from a along e that is nearest to the origin.
inline Vec4 nearestOnSegment(const Vec4& a, const Vec4& e) {
  const Float4 square = max(dot(e, e), Float4(1e-37f));
  const Float4 t = max(Float4() - dot(a, e), Float4()) / square;
  return a + e * min(t, Float4(1.0f));
}

inline Float4 largest(const Vec4& v) {
  const Float4 zero;
  return max(max(max(v.x, zero - v.x), max(v.y, zero - v.y)), max(v.z, zero - v.z));
}

/// Roughly the nearest points of four triangles to the origin.
inline Vec4 nearest(const Triangles4& t) {
  const Vec4 ab = t.b - t.a, bc = t.c - t.b, ca = t.a - t.c;
  const Vec4 q0 = nearestOnSegment(t.a, ab), q1 = nearestOnSegment(t.b, bc), q2 = nearestOnSegment(t.c, ca);
  const Float4 s0 = dot(q0, q0), s1 = dot(q1, q1), s2 = dot(q2, q2);
  Vec4 q = selectLessEqual(s0, s1, q0, q1);
  q = selectLessEqual(s2, min(s0, s1), q2, q);
  // The foot of the perpendicular, where it lies within all three edges.
  const Vec4 n = cross(ab, bc);
  const Float4 inside = min(min(dot(n, cross(t.a, ab)), dot(n, cross(t.b, bc))), dot(n, cross(t.c, ca)));
  const Float4 square = max(dot(n, n), Float4(1e-37f));
  return selectLessEqual(inside, Float4(), q, n * (dot(n, t.a) / square));
}

}  // namespace filter

/// Unit vectors from roughly the nearest points of four triangles to the origin; 0 where the origin is on
/// one.
inline Vec4 awayFrom(const Triangles4& t) {
  const Vec4 q = filter::nearest(t);
  const Float4 square = dot(q, q);
  // Below 1e-15 m the direction is noise; u = 0 then bounds the distance by 0, which always holds.
  const Float4 least(1e-30f);
  const Float4 inverse = selectLessEqual(least, square, Float4(-1.0f) / sqrt(max(square, least)), Float4());
  return q * inverse;
}

/// The bound of four triangles for a point that moves from the origin; `away` comes from awayFrom().
inline DistanceBound4 boundDistance(const Triangles4& t, const Vec4& away, const Vec4& motion) {
  // u . v is off by at most 8 half units in the last place of |v|, including the rounding of v and of |u|.
  const Float4 length =
      max(max(filter::largest(t.a), filter::largest(t.b)), filter::largest(t.c)) + filter::largest(motion);
  return {Float4() - max(max(dot(away, t.a), dot(away, t.b)), dot(away, t.c)), dot(away, motion),
          length * Float4(0x1p-19f)};
}

/// awayFrom() at the time up to `latest` at which the point is nearest to the triangles: a bound along these
/// directions is the tightest for a point that glides along the triangles.
inline Vec4 awayInPassing(const Triangles4& t, const Vec4& away, const Vec4& motion, Float4 latest) {
  const Float4 distance = Float4() - max(max(dot(away, t.a), dot(away, t.b)), dot(away, t.c));
  const Float4 square = max(dot(motion, motion), Float4(1e-37f));
  const Float4 when = min(max(Float4() - distance * dot(away, motion) / square, Float4()), latest);
  const Vec4 passed = motion * when;
  return awayFrom({t.a - passed, t.b - passed, t.c - passed});
}

}  // namespace tandem::haptics
