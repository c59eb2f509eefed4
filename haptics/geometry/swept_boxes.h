#pragma once

// Continuous collision of a moving point or ball with the children of a BVH node, in float: which children it
// may meet, and when at the earliest. Errors of rounding only ever report a meeting too much or too early.

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include "haptics/base/simd4.h"
#include "haptics/geometry/leaf_slab.h"
#include "haptics/geometry/outward.h"
#include "haptics/geometry/triangle_bvh.h"

namespace tandem::haptics {

/// A moving point against four boxes at a time: the slab test (Kay & Kajiya 1986, "Ray tracing complex
/// scenes").
class SweptPoint {
 public:
  /// Boxes are inflated by `radius` plus an allowance for float rounding: of the origin, of the differences
  /// and of t, each a few units in the last place of `largest`, the largest length involved.
  SweptPoint(const glm::dvec3& origin, const glm::dvec3& motion, double radius, double largest) {
    const Float4 inflate(roundUp(radius + largest * 0x1p-20));
    for (int axis = 0; axis < 3; ++axis) {
      const Float4 start(static_cast<float>(origin[axis]));
      above_[axis] = start + inflate;
      below_[axis] = start - inflate;
      const double least = largest * 0x1p-60;
      const double step = std::abs(motion[axis]) > least ? motion[axis] : std::copysign(least, motion[axis]);
      inverse_[axis] = Float4(static_cast<float>(std::clamp(1.0 / step, -1e30, 1e30)));
    }
  }

  /// Which children the motion meets before `latest` (a fraction of the motion), with lower bounds of the
  /// times.
  int enter(const TriangleBvh::Node& node, float latest, float* bounds) const {
    Float4 enter, leave(latest);
    for (int axis = 0; axis < 3; ++axis) {
      const Float4 t0 = (Float4::load(node.low[axis]) - above_[axis]) * inverse_[axis];
      const Float4 t1 = (Float4::load(node.high[axis]) - below_[axis]) * inverse_[axis];
      enter = max(enter, min(t0, t1));
      leave = min(leave, max(t0, t1));
    }
    enter = enter * Float4(1.0f - 0x1p-20f);
    enter.store(bounds);
    return lessEqualMask(enter, leave);
  }

 private:
  Float4 above_[3], below_[3], inverse_[3];  // inflated start; 1 / motion
};

/// A moving ball against four boxes at a time. Slabs of the inflated box are tight for a ball
/// smaller than the box. For a larger ball, the distance to the content of a box is at least
///     u . (x - c) - max over the contents of u . (y - c)
/// for every unit vector u; u points from roughly the nearest point to the ball's centre. The box bounds the
/// maximum, and for a leaf of nearly flat triangles so does its slab: u = a N + w, a >= 0.
class SweptBall {
 public:
  SweptBall(const glm::dvec3& origin, const glm::dvec3& motion, double radius, double largest)
      : slabs_(origin, motion, radius, largest),
        reach_(roundUp(radius + largest * 0x1p-19)),
        far_(glm::length(motion) > radius) {
    const auto four = [](const glm::dvec3& v) {
      return Vec4{Float4(static_cast<float>(v.x)), Float4(static_cast<float>(v.y)),
                  Float4(static_cast<float>(v.z))};
    };
    origin_ = four(origin);
    motion_ = four(motion);
  }

  /// Which children the ball may meet before `latest`, with lower bounds of the times as the visiting order.
  /// A bound is negative where the start is within reach already. The deepest such child comes first, because
  /// it most likely holds an early hit that excludes the others.
  int enter(const TriangleBvh::Node& node, float latest, float* bounds) const {
    int mask = 15;
    if (far_) {
      mask = slabs_.enter(node, latest, bounds);
      if (mask == 0) return 0;
    } else {
      Float4().store(bounds);
    }
    const Separation at = separate(node);
    const Float4 t = timeOf(at);
    const int met = lessEqualMask(at.gap, Float4()) | lessEqualMask(t, Float4(latest));
    selectLessEqual(at.gap, Float4(), at.gap, max(t, Float4::load(bounds))).store(bounds);
    return mask & met;
  }

  /// The same without an order, with the bounds behind it: the distance from a point x to the content of a
  /// child is at least distance + away . (x - origin), up to the rounding that reach_ allows for.
  struct Proof {
    Vec4 away;        // unit vectors, or 0
    Float4 distance;  // m
  };
  int enter(const TriangleBvh::Node& node, float latest, Proof& proof) const {
    const Separation at = separate(node);
    const Float4 inverse = Float4(1.0f) / max(at.length, Float4(1e-18f));
    proof = {at.u * inverse, (at.gap + reach_ * at.length) * inverse};
    const int met = lessEqualMask(at.gap, Float4()) | lessEqualMask(timeOf(at), Float4(latest));
    alignas(16) float bounds[4];
    return far_ && met != 0 ? met & slabs_.enter(node, latest, bounds) : met;
  }

 private:
  /// All lengths are times |u|: the ball's gap at the start.
  struct Separation {
    Vec4 u;
    Float4 length, gap;
  };

  Separation separate(const TriangleBvh::Node& node) const {
    const Vec4 low = node.lows(), high = node.highs();
    const Float4 half(0.5f);
    const Vec4 centre = (low + high) * half, extent = (high - low) * half, d = origin_ - centre;
    const Slab4 slab = unpackSlabs(node.slab, extent);
    // Roughly the nearest point: the foot on the slab's face, within the box.
    const Float4 least(1e-37f), inverse = roughReciprocal(max(dot(slab.normal, slab.normal), least));
    const Float4 height = max(dot(slab.normal, d) - slab.offset, Float4()) * inverse;
    const Vec4 foot = d - slab.normal * height;
    const Vec4 u = d - min(max(foot, Vec4{} - extent), extent);
    const Float4 along = max(dot(u, slab.normal), Float4()) * inverse;
    const Vec4 rest = u - slab.normal * along;
    const Float4 length = sqrt(dot(u, u));
    return {u, length, dot(u, d) - along * slab.offset - dot(abs(rest), extent) - reach_ * length};
  }

  /// A lower bound of the time at which the gap is closed.
  Float4 timeOf(const Separation& at) const {
    const Float4 nearing = Float4() - dot(at.u, motion_);
    return at.gap * roughReciprocal(max(nearing, Float4(1e-37f))) * Float4(1.0f - 0x1p-10f);
  }

  SweptPoint slabs_;
  Vec4 origin_, motion_;
  Float4 reach_;
  bool far_;  // the slabs add nothing for a motion shorter than the ball
};

}  // namespace tandem::haptics
