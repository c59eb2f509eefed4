#include "client/report/baseline_proxy.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <glm/geometric.hpp>

#include "assets/base/assert.h"

namespace tandem::client::report {

template <typename Real>
SegmentTree<Real>::SegmentTree(const assets::Scene& scene) {
  for (const assets::Part& part : scene.parts) {
    if (part.mesh == assets::kNone) continue;
    const assets::Mesh& mesh = scene.meshes[part.mesh];
    for (const auto& t : mesh.triangles)
      for (const std::uint32_t v : t)
        corners_.push_back(Vec(transformPoint(part.worldFromPart, mesh.positions[v])));
  }
  const auto count = static_cast<std::uint32_t>(corners_.size() / 3);
  std::vector<Vec> centres(count);
  for (std::uint32_t i = 0; i < count; ++i) {
    order_.push_back(i);
    centres[i] = (corners_[3 * i] + corners_[3 * i + 1] + corners_[3 * i + 2]) / Real(3);
  }
  nodes_.reserve(count);
  nodes_.emplace_back();
  if (count > 0) build(0, 0, count, centres);
  size_ = count > 0 ? glm::length(nodes_[0].box.high - nodes_[0].box.low) : Real(0);
}

template <typename Real>
void SegmentTree<Real>::build(std::uint32_t node, std::uint32_t first, std::uint32_t count,
                              std::vector<Vec>& centres) {
  Box box, middle;
  for (std::uint32_t i = first; i < first + count; ++i) {
    for (std::uint32_t k = 0; k < 3; ++k) {
      box.low = glm::min(box.low, corners_[3 * order_[i] + k]);
      box.high = glm::max(box.high, corners_[3 * order_[i] + k]);
    }
    middle.low = glm::min(middle.low, centres[order_[i]]);
    middle.high = glm::max(middle.high, centres[order_[i]]);
  }
  nodes_[node].box = box;
  if (count <= kLeaf) {
    nodes_[node].first = first;
    nodes_[node].count = count;
    return;
  }
  const Vec extent = middle.high - middle.low;
  const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
  const auto begin = order_.begin() + first;
  std::nth_element(begin, begin + count / 2, begin + count,
                   [&](std::uint32_t a, std::uint32_t b) { return centres[a][axis] < centres[b][axis]; });
  const auto child = static_cast<std::uint32_t>(nodes_.size());
  nodes_[node].first = child;
  nodes_.emplace_back();
  nodes_.emplace_back();
  build(child, first, count / 2, centres);
  build(child + 1, first + count / 2, count - count / 2, centres);
}

template <typename Real>
bool SegmentTree<Real>::meets(const Box& box, const Vec& from, const Vec& inverseDisplacement,
                              Real limit) const {
  Real enter = Real(0), leave = limit;
  for (int i = 0; i < 3; ++i) {
    const Real a = (box.low[i] - from[i]) * inverseDisplacement[i],
               b = (box.high[i] - from[i]) * inverseDisplacement[i];
    // NaN where the segment lies in a box's face: min and max then ignore that slab.
    enter = std::max(enter, std::min(a, b));
    leave = std::min(leave, std::max(a, b));
  }
  // A few roundings of slack keep a hit on a box's face.
  return enter <= leave + Real(8) * std::numeric_limits<Real>::epsilon() * (Real(1) + std::abs(leave));
}

/// Möller & Trumbore 1997, "Fast, minimum storage ray/triangle intersection".
template <typename Real>
void SegmentTree<Real>::testTriangle(std::uint32_t triangle, const Vec& from, const Vec& displacement,
                                     Hit& hit) const {
  const Vec &a = corners_[3 * triangle], &b = corners_[3 * triangle + 1], &c = corners_[3 * triangle + 2];
  const Vec ab = b - a, ac = c - a, p = glm::cross(displacement, ac);
  const Real determinant = glm::dot(ab, p);
  if (determinant == Real(0)) return;
  const Vec offset = from - a, q = glm::cross(offset, ab);
  const Real u = glm::dot(offset, p) / determinant, v = glm::dot(displacement, q) / determinant;
  const Real t = glm::dot(ac, q) / determinant;
  if (u < Real(0) || v < Real(0) || u + v > Real(1) || t < Real(0) || t >= hit.t) return;
  const Vec normal = glm::normalize(glm::cross(ab, ac));
  hit = {t, glm::dot(normal, displacement) > Real(0) ? -normal : normal, triangle};
}

template <typename Real>
bool SegmentTree<Real>::firstHit(const Vec& from, const Vec& displacement, Hit& hit) const {
  const Vec inverse(Real(1) / displacement.x, Real(1) / displacement.y, Real(1) / displacement.z);
  std::array<std::uint32_t, 64> stack;
  std::size_t top = 0;
  stack[top++] = 0;
  const std::uint32_t before = hit.triangle;
  while (top > 0) {
    const Node& node = nodes_[stack[--top]];
    if (!meets(node.box, from, inverse, hit.t)) continue;
    if (node.count == 0) {
      ASSERT(top + 2 <= stack.size());  // splits at the median keep the tree below this depth
      stack[top++] = node.first;
      stack[top++] = node.first + 1;
    }
    for (std::uint32_t i = 0; i < node.count; ++i)
      testTriangle(order_[node.first + i], from, displacement, hit);
  }
  return hit.triangle != before;
}

template <typename Real>
BaselineProxy<Real>::BaselineProxy(const SegmentTree<Real>& tree, PlaneOrder order, const glm::dvec3& start)
    : tree_(tree), order_(order), position_(start) {
  // Single precision resolves world coordinates to some 1e-7 of their size; the gap must be well above that.
  const Real reach =
      std::max({tree.size(), std::abs(position_.x), std::abs(position_.y), std::abs(position_.z)});
  gap_ = reach * Real(256) * std::numeric_limits<Real>::epsilon();
}

template <typename Real>
typename BaselineProxy<Real>::Vec BaselineProxy<Real>::target(const Vec& goal) const {
  if (planes_ == 0) return goal;
  if (planes_ == 1) return goal + normals_[0] * (glm::dot(point_ - goal, normals_[0]) + gap_);
  const Vec line = glm::cross(normals_[0], normals_[1]);
  const Real length = glm::length(line);
  if (!(length > Real(0))) return position_;
  return position_ + line * (glm::dot(goal - position_, line) / (length * length));
}

template <typename Real>
bool BaselineProxy<Real>::step(const Vec& goal) {
  const Vec displacement = target(goal) - position_;
  typename SegmentTree<Real>::Hit hit;
  if (!tree_.firstHit(position_, displacement, hit)) {
    position_ += displacement;
    planes_ = 0;
    return false;
  }
  if (planes_ == 0) point_ = position_ + displacement * hit.t;
  // The proxy stops short of the plane by the gap, but never moves backwards.
  const Real approach = -glm::dot(displacement, hit.normal);
  const Real share = approach > Real(0) ? hit.t - gap_ / approach : Real(0);
  position_ += displacement * std::max(share, Real(0));
  if (planes_ < 2) normals_[planes_] = hit.normal;
  planes_ = planes_ == 2 ? 0 : planes_ + 1;
  return planes_ > 0;
}

template <typename Real>
glm::dvec3 BaselineProxy<Real>::follow(const glm::dvec3& goal) {
  const Vec g(goal);
  if (order_ == PlaneOrder::onePlaneATick) {
    step(g);
  } else {
    planes_ = 0;
    while (step(g)) {
    }
  }
  return glm::dvec3(position_);
}

template class SegmentTree<float>;
template class SegmentTree<double>;
template class BaselineProxy<float>;
template class BaselineProxy<double>;

}  // namespace tandem::client::report
