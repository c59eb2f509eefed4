#pragma once

// A k-d tree over some points, which finds those near a segment.

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <glm/vec3.hpp>

namespace tandem {

class PointTree {
 public:
  /// A tree of points[i] for all i of `indices`. `points` must outlive it. O(N log N).
  PointTree(const std::vector<glm::dvec3>& points, std::vector<std::uint32_t> indices);

  /// Calls visit(index) for every point within `reach` m of the segment a b, and for few others. `steps`
  /// bounds the work: each node and point looked at takes one, and the walk ends early at 0.
  template <typename Visit>
  void forEachNear(const glm::dvec3& a, const glm::dvec3& b, double reach, std::size_t& steps,
                   Visit&& visit) const {
    if (nodes_.empty()) return;
    std::array<std::uint32_t, 64> stack;  // halves of 2^32 points are 32 levels deep
    std::size_t top = 0;
    stack[top++] = 0;
    while (top > 0) {
      if (steps == 0) return;
      --steps;
      const std::uint32_t index = stack[--top];
      const Node& node = nodes_[index];
      if (!passes(a, b, reach, node)) continue;
      if (node.second != 0) {
        stack[top++] = node.second;
        stack[top++] = index + 1;
        continue;
      }
      for (std::uint32_t i = node.begin; i < node.end; ++i) visit(indices_[i]);
      steps -= std::min<std::size_t>(steps, node.end - node.begin);
    }
  }

 private:
  static constexpr std::uint32_t kMaxInLeaf = 8;
  /// The points of indices_[begin, end). Its halves are the next node and `second`, which is 0 in a leaf.
  struct Node {
    glm::dvec3 low{0.0}, high{0.0};  // m
    std::uint32_t begin = 0, end = 0, second = 0;
  };

  static bool passes(const glm::dvec3& a, const glm::dvec3& b, double reach, const Node& node);
  std::uint32_t build(std::uint32_t begin, std::uint32_t end);

  const std::vector<glm::dvec3>& points_;
  std::vector<std::uint32_t> indices_;
  std::vector<Node> nodes_;
};

}  // namespace tandem
