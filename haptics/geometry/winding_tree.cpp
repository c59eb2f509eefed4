#include "haptics/geometry/winding_tree.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>

#include <glm/geometric.hpp>

#include "assets/base/assert.h"
#include "assets/base/median_split.h"

namespace tandem::haptics {
namespace {

constexpr std::uint32_t kMaxLeaf = 8;
/// A node counts as a dipole from this many radii on.
constexpr double kFar = 2.5;
/// Halving the count at each level, 32 levels suffice for every mesh; two children wait at each.
constexpr std::size_t kStackSize = 72;

}  // namespace

double windingOfTriangle(const glm::dvec3& p, const Triangle& triangle) {
  const glm::dvec3 a = triangle.a - p, b = triangle.b - p, c = triangle.c - p;
  const double la = glm::length(a), lb = glm::length(b), lc = glm::length(c);
  // tan(omega / 2) = a . (b x c) / (|a||b||c| + (a . b)|c| + (b . c)|a| + (c . a)|b|), omega the solid angle
  const double volume = glm::dot(a, glm::cross(b, c));
  const double share = la * lb * lc + glm::dot(a, b) * lc + glm::dot(b, c) * la + glm::dot(c, a) * lb;
  if (volume == 0.0 && share == 0.0) return 0.0;
  return std::atan2(volume, share) / (2.0 * std::numbers::pi);
}

WindingTree::WindingTree(const assets::Mesh& mesh) : mesh_(&mesh), order_(mesh.triangles.size()) {
  std::iota(order_.begin(), order_.end(), 0u);
  std::vector<glm::dvec3> middles(order_.size());
  for (std::uint32_t t = 0; t < middles.size(); ++t) {
    const Triangle corners = triangle(t);
    middles[t] = (corners.a + corners.b + corners.c) / 3.0;
  }
  nodes_.emplace_back();
  nodes_[0].count = static_cast<std::uint32_t>(order_.size());
  ASSERT(nodes_[0].count == order_.size() && middles.size() == order_.size());
  split(0, middles);
}

Triangle WindingTree::triangle(std::uint32_t index) const {
  const auto& t = mesh_->triangles[index];
  return {mesh_->positions[t[0]], mesh_->positions[t[1]], mesh_->positions[t[2]]};
}

void WindingTree::split(std::uint32_t node, std::vector<glm::dvec3>& middles) {
  measure(nodes_[node]);
  const std::uint32_t first = nodes_[node].first, count = nodes_[node].count;
  ASSERT(first + count <= order_.size());
  if (count <= kMaxLeaf) return;
  assets::Bounds box;
  for (std::uint32_t i = first; i < first + count; ++i) {
    box.include(middles[order_[i]]);
  }
  splitAtMedian(order_, first, first + count, box.max - box.min, [&](std::uint32_t i) { return middles[i]; });
  const auto children = static_cast<std::uint32_t>(nodes_.size());
  nodes_.resize(nodes_.size() + 2);
  nodes_[node].children = children;
  nodes_[children].first = first;
  nodes_[children].count = count / 2;
  nodes_[children + 1].first = first + count / 2;
  nodes_[children + 1].count = count - count / 2;
  split(children, middles);
  split(children + 1, middles);
}

void WindingTree::measure(Node& node) const {
  double weight = 0.0;
  assets::Bounds box;
  for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
    const Triangle t = triangle(order_[i]);
    const double size = glm::length(areaVector(t));
    node.centre += size / 3.0 * (t.a + t.b + t.c);
    weight += size;
    for (const glm::dvec3& corner : {t.a, t.b, t.c}) {
      box.include(corner);
    }
  }
  node.centre = weight > 0.0 ? node.centre / weight : 0.5 * (box.min + box.max);
  for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
    const Triangle t = triangle(order_[i]);
    const glm::dvec3 area = 0.5 * areaVector(t);
    node.area += area;
    node.moment += glm::outerProduct((t.a + t.b + t.c) / 3.0 - node.centre, area);
    for (const glm::dvec3& corner : {t.a, t.b, t.c})
      node.radius = std::max(node.radius, glm::distance(corner, node.centre));
  }
}

double WindingTree::at(const glm::dvec3& p) const {
  double sum = 0.0;
  std::array<std::uint32_t, kStackSize> stack;
  std::size_t size = 1;
  stack[0] = 0;
  while (size > 0) {
    const Node& node = nodes_[stack[--size]];
    const glm::dvec3 r = node.centre - p;
    const double square = glm::dot(r, r);
    if (square > kFar * kFar * node.radius * node.radius && node.count > 1) {
      // The dipole and its first derivative, with the area vector a and the moment M about the centre:
      // (a . r + tr M - 3 r^T M r / r^2) / (4 pi r^3)
      const double inverse = 1.0 / std::sqrt(square), cube = inverse * inverse * inverse;
      const double trace = node.moment[0][0] + node.moment[1][1] + node.moment[2][2];
      const double twist = glm::dot(r, node.moment * r) * inverse * inverse;
      sum += cube * (glm::dot(node.area, r) + trace - 3.0 * twist) / (4.0 * std::numbers::pi);
    } else if (node.children != 0) {
      ASSERT(size + 2 <= kStackSize);
      stack[size++] = node.children;
      stack[size++] = node.children + 1;
    } else {
      for (std::uint32_t i = node.first; i < node.first + node.count; ++i)
        sum += windingOfTriangle(p, triangle(order_[i]));
    }
  }
  return sum;
}

}  // namespace tandem::haptics
