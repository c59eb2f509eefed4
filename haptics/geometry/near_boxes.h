#pragma once

// The children of a BVH node that may hold a point near to a given one, in float. Errors of rounding only
// ever make a bound too small.

#include <limits>

#include <glm/vec3.hpp>

#include "haptics/base/simd4.h"
#include "haptics/geometry/leaf_slab.h"
#include "haptics/geometry/outward.h"
#include "haptics/geometry/triangle_bvh.h"

namespace tandem::haptics {

class NearBoxes {
 public:
  /// `point` is relative to the tree's centre; `largest` bounds the coordinates of both, m.
  NearBoxes(const glm::dvec3& point, double largest) : rounding_(roundUp(largest * 0x1p-19)) {
    Float4* const at[3] = {&point_.x, &point_.y, &point_.z};
    for (int axis = 0; axis < 3; ++axis) {
      // The point is an interval of two floats around the true one.
      low_[axis] = Float4(roundDown(point[axis]));
      high_[axis] = Float4(roundUp(point[axis]));
      *at[axis] = Float4(static_cast<float>(point[axis]));
    }
  }

  /// The children that may hold a point within `reach` m, with lower bounds of their distances, m. The
  /// distance to the content of a box is at least that to the box, and as in SweptBall at least
  ///     u . (x - c) - max over the contents of u . (y - c)
  /// for every unit vector u: boxes of triangles askew to the axes are thick, their slabs are not.
  int within(const TriangleBvh::Node& node, float reach, float* bounds) const {
    // The factor covers the rounding of the sum of squares and of the root.
    constexpr float kBelow = 1.0f - 16.0f * std::numeric_limits<float>::epsilon();
    Float4 square;
    for (int axis = 0; axis < 3; ++axis) {
      const Float4 below = Float4::load(node.low[axis]) - high_[axis];
      const Float4 above = low_[axis] - Float4::load(node.high[axis]);
      const Float4 d = max(max(below, above), Float4());
      square = square + d * d;
    }
    const Float4 box = sqrt(square * Float4(kBelow));
    if (lessEqualMask(box, Float4(reach)) == 0) return 0;
    const Float4 bound = max(slabDistance(node), box);
    bound.store(bounds);
    return lessEqualMask(bound, Float4(reach));
  }

 private:
  Float4 slabDistance(const TriangleBvh::Node& node) const {
    const Vec4 low = node.lows(), high = node.highs();
    const Float4 half(0.5f), least(1e-37f);
    const Vec4 extent = (high - low) * half, d = point_ - (low + high) * half;
    const Slab4 slab = unpackSlabs(node.slab, extent);
    const Float4 inverse = roughReciprocal(max(dot(slab.normal, slab.normal), least));
    // Roughly the nearest point: the foot on the slab's face, within the box.
    const Float4 height = max(dot(slab.normal, d) - slab.offset, Float4()) * inverse;
    const Vec4 foot = d - slab.normal * height;
    const Vec4 u = d - min(max(foot, Vec4{} - extent), extent);
    const Float4 along = max(dot(u, slab.normal), Float4()) * inverse;
    const Float4 gap = dot(u, d) - along * slab.offset - dot(abs(u - slab.normal * along), extent);
    return gap / sqrt(max(dot(u, u), least)) - rounding_;
  }

  Vec4 point_;
  Float4 low_[3], high_[3];
  Float4 rounding_;
};

}  // namespace tandem::haptics
