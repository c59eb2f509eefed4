#include "assets/base/point_tree.h"

#include <algorithm>
#include <utility>

#include <glm/common.hpp>

#include "assets/base/median_split.h"

namespace tandem {

PointTree::PointTree(const std::vector<glm::dvec3>& points, std::vector<std::uint32_t> indices)
    : points_(points), indices_(std::move(indices)) {
  if (indices_.empty()) return;
  nodes_.reserve(indices_.size() / 2);
  build(0, static_cast<std::uint32_t>(indices_.size()));
}

std::uint32_t PointTree::build(std::uint32_t begin, std::uint32_t end) {
  const auto index = static_cast<std::uint32_t>(nodes_.size());
  Node node{points_[indices_[begin]], points_[indices_[begin]], begin, end, 0};
  for (std::uint32_t i = begin + 1; i < end; ++i) {
    node.low = glm::min(node.low, points_[indices_[i]]);
    node.high = glm::max(node.high, points_[indices_[i]]);
  }
  nodes_.push_back(node);
  if (end - begin <= kMaxInLeaf) return index;
  const std::uint32_t middle =
      splitAtMedian(indices_, begin, end, node.high - node.low, [&](std::uint32_t i) { return points_[i]; });
  build(begin, middle);
  nodes_[index].second = build(middle, end);
  return index;
}

bool PointTree::passes(const glm::dvec3& a, const glm::dvec3& b, double reach, const Node& node) {
  double from = 0.0, to = 1.0;
  for (int axis = 0; axis < 3; ++axis) {
    const double low = node.low[axis] - reach - a[axis], high = node.high[axis] + reach - a[axis],
                 along = b[axis] - a[axis];
    if (along == 0.0) {
      if (low > 0.0 || high < 0.0) return false;
      continue;
    }
    const double x = low / along, y = high / along;
    from = std::max(from, std::min(x, y));
    to = std::min(to, std::max(x, y));
  }
  // The quotients are rounded by some units in the last place; the reach is a billion of them.
  return from <= to;
}

}  // namespace tandem
