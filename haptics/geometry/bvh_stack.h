#pragma once

// The stack of a walk over a TriangleBvh: what is still to be visited, nearest first.

#include <array>
#include <cstdint>

#include "haptics/geometry/triangle_bvh.h"

namespace tandem::haptics {

/// A node (or leaf) still to be visited, with a lower bound of its result.
struct PendingNode {
  std::uint32_t child;
  float bound;
};

/// Holds the nodes of one walk. A node has four children, so each level leaves at most three behind.
class BvhStack {
 public:
  bool pop(PendingNode& next) {
    if (size_ == 0) return false;
    next = entries_[--size_];
    return true;
  }
  /// Pushes the children of `mask`, the one with the least bound last, so that it is popped first.
  void pushOrdered(const std::uint32_t* child, const float* bound, int mask) {
    const int first = size_;
    for (int i = 0; i < 4; ++i) {
      if ((mask & (1 << i)) == 0 || child[i] == TriangleBvh::kEmptyChild) continue;
      int at = size_++;
      for (; at > first && entries_[at - 1].bound < bound[i]; --at) entries_[at] = entries_[at - 1];
      entries_[at] = {child[i], bound[i]};
    }
  }

 private:
  static constexpr int kSize = 3 * TriangleBvh::kMaxDepth + 4;

  std::array<PendingNode, kSize> entries_;
  int size_ = 0;
};

}  // namespace tandem::haptics
