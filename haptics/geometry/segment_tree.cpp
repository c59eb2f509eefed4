#include "haptics/geometry/segment_tree.h"

#include <algorithm>
#include <array>
#include <numeric>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "assets/base/assert.h"
#include "assets/base/median_split.h"

namespace tandem::haptics {
namespace {

constexpr std::uint32_t kLeaf = 4;
constexpr int kMaxBisections = 64;  // bisections of at most 2^32 triangles

/// Whether a segment passes through a box, widened for rounding. `inverse` is 1 / (to - from) of the segment.
bool segmentMeets(const glm::dvec3& low, const glm::dvec3& high, const glm::dvec3& from,
                  const glm::dvec3& inverse) {
  const glm::dvec3 a = (low - from) * inverse, b = (high - from) * inverse;
  const glm::dvec3 near = glm::min(a, b), far = glm::max(a, b);
  const double enter = std::max({near.x, near.y, near.z, 0.0}), leave = std::min({far.x, far.y, far.z, 1.0});
  return enter <= leave + 1e-12;
}

glm::dvec3 inverseOf(const glm::dvec3& path) {
  glm::dvec3 inverse;
  for (int i = 0; i < 3; ++i) inverse[i] = std::abs(path[i]) > 1e-300 ? 1.0 / path[i] : 1e300;
  return inverse;
}

}  // namespace

SegmentTree::SegmentTree(const assets::Mesh& mesh) : mesh_(&mesh), order_(mesh.triangles.size()) {
  std::iota(order_.begin(), order_.end(), 0u);
  for (const auto& t : mesh.triangles) {
    centres_.push_back(mesh.positions[t[0]] + mesh.positions[t[1]] + mesh.positions[t[2]]);
  }
  if (!order_.empty()) build(0, static_cast<std::uint32_t>(order_.size()));
  centres_ = {};
}

std::uint32_t SegmentTree::build(std::uint32_t begin, std::uint32_t end) {
  ASSERT(begin < end && end <= order_.size());
  Node node;
  node.low = glm::dvec3(1e300);
  node.high = glm::dvec3(-1e300);
  glm::dvec3 least = node.low,
             greatest = node.high;  // bounds of the centres, so that long parallel triangles separate
  for (std::uint32_t i = begin; i < end; ++i) {
    least = glm::min(least, centres_[order_[i]]);
    greatest = glm::max(greatest, centres_[order_[i]]);
    for (const std::uint32_t corner : mesh_->triangles[order_[i]]) {
      node.low = glm::min(node.low, mesh_->positions[corner]);
      node.high = glm::max(node.high, mesh_->positions[corner]);
    }
  }
  // Planar content gets some thickness against rounding.
  const glm::dvec3 margin =
      1e-14 * (glm::abs(node.low) + glm::abs(node.high)) + 1e-12 * (node.high - node.low);
  node.low -= margin;
  node.high += margin;
  const auto index = static_cast<std::uint32_t>(nodes_.size());
  if (end - begin <= kLeaf) {
    node.first = begin;
    node.count = end - begin;
    nodes_.push_back(node);
    return index;
  }
  const std::uint32_t middle =
      splitAtMedian(order_, begin, end, greatest - least, [&](std::uint32_t i) { return centres_[i]; });
  nodes_.push_back(node);
  build(begin, middle);
  nodes_[index].first = build(middle, end);
  return index;
}

void SegmentTree::cross(std::uint32_t triangle, const glm::dvec3& from, const glm::dvec3& path,
                        std::vector<SegmentCrossing>& found) const {
  const auto& t = mesh_->triangles[triangle];
  const glm::dvec3 a = mesh_->positions[t[0]] - from, b = mesh_->positions[t[1]] - from;
  const glm::dvec3 c = mesh_->positions[t[2]] - from;
  // Signed volumes of the line with the three edges: equal signs mean that the line passes through the
  // triangle.
  const double u = glm::dot(path, glm::cross(b, a)), v = glm::dot(path, glm::cross(c, b));
  const double w = glm::dot(path, glm::cross(a, c));
  const bool negative = u <= 0.0 && v <= 0.0 && w <= 0.0, positive = u >= 0.0 && v >= 0.0 && w >= 0.0;
  if (negative == positive) return;
  const glm::dvec3 normal = glm::cross(b - a, c - a);
  const double height = glm::dot(normal, a), slope = glm::dot(normal, path);
  if (slope == 0.0) return;
  const double share = height / slope;
  if (!(share >= 0.0 && share <= 1.0)) return;
  found.push_back({share, triangle, slope > 0.0 ? 1 : -1});
}

void SegmentTree::crossings(const glm::dvec3& from, const glm::dvec3& to,
                            std::vector<SegmentCrossing>& found) const {
  if (nodes_.empty()) return;
  const glm::dvec3 path = to - from, inverse = inverseOf(path);
  std::array<std::uint32_t, kMaxBisections> stack;
  int size = 0;
  stack[static_cast<std::size_t>(size++)] = 0;
  while (size > 0) {
    const std::uint32_t index = stack[static_cast<std::size_t>(--size)];
    const Node& node = nodes_[index];
    if (!segmentMeets(node.low, node.high, from, inverse)) continue;
    if (node.count > 0) {
      for (std::uint32_t i = 0; i < node.count; ++i) cross(order_[node.first + i], from, path, found);
      continue;
    }
    ASSERT(size + 2 <= kMaxBisections);
    stack[static_cast<std::size_t>(size++)] = node.first;
    stack[static_cast<std::size_t>(size++)] = index + 1;
  }
}

}  // namespace tandem::haptics
