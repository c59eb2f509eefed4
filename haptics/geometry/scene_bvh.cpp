#include "haptics/geometry/scene_bvh.h"

#include <algorithm>

#include "assets/base/assert.h"

namespace tandem::haptics {
namespace {

assets::Bounds merge(const assets::Bounds& a, const assets::Bounds& b) {
  return {glm::min(a.min, b.min), glm::max(a.max, b.max)};
}

bool equal(const assets::Bounds& a, const assets::Bounds& b) { return a.min == b.min && a.max == b.max; }

}  // namespace

SceneBvh::SceneBvh(std::span<const assets::Bounds> boxes) : leafOf_(boxes.size(), kNoNode) {
  std::vector<PartId> parts;
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    if (boxes[i].min.x <= boxes[i].max.x) parts.push_back(static_cast<PartId>(i));
  }
  if (parts.empty()) return;
  nodes_.reserve(2 * parts.size() - 1);
  build(parts, boxes, kNoNode);

  ASSERT(nodes_.size() == 2 * parts.size() - 1);
}

std::uint32_t SceneBvh::build(std::span<PartId> parts, std::span<const assets::Bounds> boxes,
                              std::uint32_t parent) {
  ASSERT(!parts.empty());
  const auto index = static_cast<std::uint32_t>(nodes_.size());
  nodes_.emplace_back();
  nodes_[index].parent = parent;
  if (parts.size() == 1) {
    nodes_[index].box = boxes[parts[0]];
    nodes_[index].part = parts[0];
    leafOf_[parts[0]] = index;
    return index;
  }
  // Splits at the median centre along the widest axis: the depth is logarithmic for any layout.
  assets::Bounds centres;
  for (const PartId part : parts) {
    const glm::dvec3 c = boxes[part].min + boxes[part].max;
    centres = merge(centres, {c, c});
  }
  const glm::dvec3 size = centres.max - centres.min;
  const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  const auto middle = parts.begin() + static_cast<std::ptrdiff_t>(parts.size() / 2);
  std::nth_element(parts.begin(), middle, parts.end(), [&](PartId a, PartId b) {
    const double ka = boxes[a].min[axis] + boxes[a].max[axis], kb = boxes[b].min[axis] + boxes[b].max[axis];
    return ka != kb ? ka < kb : a < b;
  });
  const std::uint32_t left = build(parts.first(parts.size() / 2), boxes, index);
  const std::uint32_t right = build(parts.subspan(parts.size() / 2), boxes, index);
  nodes_[index].left = left;
  nodes_[index].right = right;
  nodes_[index].box = merge(nodes_[left].box, nodes_[right].box);
  return index;
}

void SceneBvh::update(PartId part, const assets::Bounds& box) {
  if (!contains(part)) return;
  Node& leaf = nodes_[leafOf_[part]];
  leaf.box = box;
  for (std::uint32_t i = leaf.parent; i != kNoNode; i = nodes_[i].parent) {
    const assets::Bounds fitted = merge(nodes_[nodes_[i].left].box, nodes_[nodes_[i].right].box);
    if (equal(fitted, nodes_[i].box)) return;
    nodes_[i].box = fitted;
  }
}

}  // namespace tandem::haptics
