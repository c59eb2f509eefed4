#pragma once

// Walks two triangle trees at once and finds the pairs of leaves that are near each other. Used by
// mesh_distance and mesh_overlap.
//
// 1. A pair is dropped only if its boxes prove it further apart than `reach`. Boxes are compared as floats in
//    both meshes' frames, with an allowance for rounding.
// 2. The nearer of several pairs is visited first, so that a reach that shrinks to the least distance found
//    soon excludes the rest. The order depends on the meshes and poses alone.
// 3. The walk allocates a stack.

#include <utility>
#include <vector>

#include <glm/gtc/quaternion.hpp>
#include <glm/mat3x3.hpp>

#include "assets/base/pose.h"
#include "haptics/base/simd4.h"
#include "haptics/geometry/box_frame.h"
#include "haptics/geometry/outward.h"
#include "haptics/geometry/triangle_bvh.h"

namespace tandem::haptics {

/// See the head of this file.
class BvhPairs {
 public:
  BvhPairs(const TriangleBvh& a, const TriangleBvh& b, const Pose& aFromB)
      : a_(a), b_(b), aFromB_(frame(a, b, aFromB)), bFromA_(frame(b, a, inverse(aFromB))) {
    const double largest = glm::length(a.bounds().max - a.bounds().min) +
                           glm::length(b.bounds().max - b.bounds().min) +
                           glm::length(transformPoint(aFromB, b.centre()) - a.centre());
    rounding_ = roundUp(largest * 0x1p-19 + 0x1p-48 * glm::length(aFromB.position));
  }

  /// Calls visit(firstA, countA, firstB, countB) for all pairs of leaves (places for leafTriangle()) that may
  /// be as near as `reach`, m. The visitor may shrink the reach; a negative reach ends the walk.
  template <typename Visit>
  void forEach(const double& reach, Visit&& visit) const {
    if (a_.empty() || b_.empty()) return;
    std::vector<Pending> stack{{0, 0, 0.0f, boxOf(a_), boxOf(b_)}};
    while (!stack.empty()) {
      const Pending next = stack.back();
      stack.pop_back();
      if (next.bound > reach || slabGap(next.boxA, next.boxB, aFromB_, bFromA_) > reach ||
          slabGap(next.boxB, next.boxA, bFromA_, aFromB_) > reach) {
        continue;
      }
      const bool leafA = (next.a & TriangleBvh::kLeafBit) != 0, leafB = (next.b & TriangleBvh::kLeafBit) != 0;
      if (leafA && leafB) {
        visit(next.a & TriangleBvh::kLeafFirstMask, TriangleBvh::leafCount(next.a),
              next.b & TriangleBvh::kLeafFirstMask, TriangleBvh::leafCount(next.b));
      } else if (leafB || (!leafA && size(next.boxA) >= size(next.boxB))) {
        descend<true>(next, reach, stack);
      } else {
        descend<false>(next, reach, stack);
      }
    }
  }

 private:
  struct Pending {
    std::uint32_t a, b;
    float bound;  // m, a lower bound of the distance of their contents
    CentredBox boxA, boxB;
  };

  static BoxFrame frame(const TriangleBvh& to, const TriangleBvh& from, const Pose& toFromFrom) {
    return {glm::mat3_cast(toFromFrom.orientation), transformPoint(toFromFrom, from.centre()) - to.centre()};
  }
  static float size(const CentredBox& box) { return glm::dot(box.half, box.half); }
  static CentredBox boxOf(const TriangleBvh& tree) {
    CentredBox box;
    for (int axis = 0; axis < 3; ++axis) {
      box.centre[axis] =
          static_cast<float>(0.5 * (tree.bounds().min[axis] + tree.bounds().max[axis]) - tree.centre()[axis]);
      box.half[axis] = roundUp(0.5 * (tree.bounds().max[axis] - tree.bounds().min[axis]));
    }
    return box;
  }
  /// Gap between the slab of `own` and the box `other`, m; negative where the slab does not separate them.
  float slabGap(const CentredBox& own, const CentredBox& other, const BoxFrame& ownFromOther,
                const BoxFrame& otherFromOwn) const {
    if (own.slab == 0) return 0.0f;
    const glm::vec3 normal = own.slabNormal();
    const float gap = glm::dot(normal, ownFromOther.point(other.centre) - own.centre) - own.slabOffset() -
                      other.reachAlong(-otherFromOwn.vector(normal));
    return gap / glm::length(normal) - rounding_;
  }
  static Float4 squaredGap(const Float4 centre[3], const Float4 half[3], const CentredBox& other) {
    Float4 square;
    for (int axis = 0; axis < 3; ++axis) {
      const Float4 gap = max(
          abs(centre[axis] - Float4(other.centre[axis])) - (half[axis] + Float4(other.half[axis])), Float4());
      square = square + gap * gap;
    }
    return square;
  }

  /// Replaces one of the two by its children: that of the first mesh where kFirst, else that of the second.
  template <bool kFirst>
  void descend(const Pending& pair, double reach, std::vector<Pending>& stack) const {
    const TriangleBvh::Node& node = kFirst ? a_.nodes()[pair.a] : b_.nodes()[pair.b];
    const CentredBox& other = kFirst ? pair.boxB : pair.boxA;
    const BoxFrame& nodeFromOther = kFirst ? aFromB_ : bFromA_;
    const BoxFrame& otherFromNode = kFirst ? bFromA_ : aFromB_;
    Float4 centre[3], half[3], rotated[3], grown[3];
    for (int axis = 0; axis < 3; ++axis) {
      const Float4 low = Float4::load(node.low[axis]), high = Float4::load(node.high[axis]);
      centre[axis] = (low + high) * Float4(0.5f);
      half[axis] = (high - low) * Float4(0.5f);
    }
    otherFromNode.apply(centre, half, rotated, grown);
    const Float4 square =
        max(squaredGap(centre, half, nodeFromOther.apply(other)), squaredGap(rotated, grown, other));
    alignas(16) float bound[4], centres[3][4], halves[3][4];
    (sqrt(square) - Float4(rounding_)).store(bound);
    for (int axis = 0; axis < 3; ++axis) {
      centre[axis].store(centres[axis]);
      half[axis].store(halves[axis]);
    }
    const std::size_t first = stack.size();
    for (int i = 0; i < 4; ++i) {
      if (node.child[i] == TriangleBvh::kEmptyChild || bound[i] > reach) continue;
      Pending next = pair;
      next.bound = bound[i];
      (kFirst ? next.a : next.b) = node.child[i];
      CentredBox& box = kFirst ? next.boxA : next.boxB;
      box.slab = node.slab[i];
      for (int axis = 0; axis < 3; ++axis) {
        box.centre[axis] = centres[axis][i];
        box.half[axis] = halves[axis][i];
      }
      // The nearest pair is popped first.
      stack.push_back(next);
      for (std::size_t at = stack.size() - 1; at > first && stack[at - 1].bound < stack[at].bound; --at) {
        std::swap(stack[at - 1], stack[at]);
      }
    }
  }

  const TriangleBvh &a_, &b_;
  BoxFrame aFromB_, bFromA_;  // between the trees' own frames, whose origins are their centres
  float rounding_;            // m, possible excess of a float bound
};

}  // namespace tandem::haptics
