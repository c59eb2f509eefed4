#pragma once

// Broad phase: a tree over the parts' world boxes, built once and refitted as parts move.
//
// 1. update() costs O(depth) and stops where a box no longer changes. Nothing allocates after construction.
// 2. The tree keeps the shape of the parts' first poses. Queries stay correct, and slow down as parts move
//    far.

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "assets/base/ids.h"
#include "assets/scene/scene.h"

namespace tandem::haptics {

class SceneBvh {
 public:
  SceneBvh() = default;
  /// boxes[part] is the world box of that part, m. An empty box is a part without geometry, which is never
  /// found.
  explicit SceneBvh(std::span<const assets::Bounds> boxes);

  /// Replaces the box of a part and refits its ancestors.
  void update(PartId part, const assets::Bounds& box);

  const assets::Bounds& box(PartId part) const { return nodes_[leafOf_[part]].box; }
  bool contains(PartId part) const { return part < leafOf_.size() && leafOf_[part] != kNoNode; }

  /// Calls visit(part) for every part whose box meets `query`, in the tree's order.
  template <typename Visit>
  void forEach(const assets::Bounds& query, Visit&& visit) const {
    if (nodes_.empty()) return;
    std::array<std::uint32_t, kMaxDepth> stack;
    int size = 0;
    stack[size++] = 0;
    while (size > 0) {
      const Node& node = nodes_[stack[--size]];
      if (!meet(node.box, query)) continue;
      if (node.part != kNoPart) {
        visit(node.part);
      } else {
        stack[size++] = node.right;
        stack[size++] = node.left;
      }
    }
  }

  static bool meet(const assets::Bounds& a, const assets::Bounds& b) {
    return a.min.x <= b.max.x && b.min.x <= a.max.x && a.min.y <= b.max.y && b.min.y <= a.max.y &&
           a.min.z <= b.max.z && b.min.z <= a.max.z;
  }

 private:
  static constexpr std::uint32_t kNoNode = 0xffffffffu;
  static constexpr int kMaxDepth = 64;  // halving 16384 parts takes 14 levels

  struct Node {
    assets::Bounds box;
    std::uint32_t left = kNoNode, right = kNoNode, parent = kNoNode;
    PartId part = kNoPart;
  };

  std::uint32_t build(std::span<PartId> parts, std::span<const assets::Bounds> boxes, std::uint32_t parent);

  std::vector<Node> nodes_;
  std::vector<std::uint32_t> leafOf_;
};

}  // namespace tandem::haptics
