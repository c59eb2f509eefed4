#include "haptics/geometry/triangle_bvh.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "assets/base/assert.h"
#include "haptics/base/simd4.h"
#include "haptics/geometry/bvh_build.h"
#include "haptics/geometry/bvh_fit.h"
#include "haptics/geometry/bvh_stack.h"
#include "haptics/geometry/cut_triangle.h"
#include "haptics/geometry/near_boxes.h"
#include "haptics/geometry/outward.h"
#include "haptics/geometry/query_work.h"
#include "haptics/geometry/swept_boxes.h"
#include "haptics/geometry/triangle_filter.h"
#include "haptics/geometry/triangle_sweep.h"

namespace tandem::haptics {
namespace {

/// +1 where the segment leaves through the triangle's outside, -1 where it enters, 0 where it misses.
int crossing(const glm::dvec3& from, const glm::dvec3& direction, const Triangle& t, const Sections* cut) {
  const glm::dvec3 a = t.a - from, b = t.b - from, c = t.c - from;
  // Signed volumes of the line with the three edges: equal signs mean that the line passes through the
  // triangle.
  const double u = glm::dot(direction, glm::cross(b, a));
  const double v = glm::dot(direction, glm::cross(c, b));
  const double w = glm::dot(direction, glm::cross(a, c));
  const bool negative = u <= 0.0 && v <= 0.0 && w <= 0.0, positive = u >= 0.0 && v >= 0.0 && w >= 0.0;
  if (negative == positive) return 0;
  const glm::dvec3 normal = areaVector(t);
  const double height = glm::dot(normal, a), slope = glm::dot(normal, direction);
  if (slope == 0.0 || height / slope < 0.0 || height / slope > 1.0) return 0;
  if (cut != nullptr && isCutAway(*cut, from + direction * (height / slope))) return 0;
  return slope > 0.0 ? 1 : -1;
}

/// False if nothing of the triangle is left.
bool closestPointOn(const Triangle& triangle, const glm::dvec3& p, const Sections* cut,
                    TrianglePoint& closest) {
  if (cut == nullptr) {
    closest = closestPointOnTriangle(p, triangle);
    return true;
  }
  const std::optional<TrianglePoint> left = closestPointOnCut(p, triangle, *cut);
  if (left) closest = *left;
  return left.has_value();
}

/// Tests triangles, four at a time, for the one that is nearest to a point. On a tie it is the one of the
/// lower index, so that the result does not depend on the order.
class NearestSearch {
 public:
  /// Triangles beyond `maxDistance` (m) do not count.
  NearestSearch(const TriangleBvh& tree, const glm::dvec3& p, double maxDistance, const Sections* cut,
                MeshPoint& nearest)
      : tree_(tree),
        p_(p),
        cut_(cut),
        nearest_(nearest),
        bestSquare_(maxDistance * maxDistance),
        bound_(roundUp(maxDistance)),
        rounding_(roundUp(tree.coordinateRounding(p))) {}

  /// At most four.
  void test(const std::uint32_t* triangles, std::uint32_t count) {
    const Triangles4 corners = leafTriangles(tree_.mesh(), triangles, count, p_);
    const DistanceBound4 least = boundDistance(corners, awayFrom(corners), Vec4{});
    const int far = lessMask(Float4(bound_) + rounding_, least.distance - least.error);
    for (std::uint32_t i = 0; i < count; ++i)
      if ((far >> i & 1) == 0) testOne(triangles[i]);
  }
  /// m, what is farther away does not count.
  float bound() const { return bound_; }
  std::uint64_t tested() const { return tested_; }
  /// Whether any has been found, whose distance is then set.
  bool finish() {
    if (found_) nearest_.distance = std::sqrt(bestSquare_);
    return found_;
  }

 private:
  void testOne(std::uint32_t index) {
    ++tested_;
    TrianglePoint closest;
    if (!closestPointOn(tree_.triangle(index), p_, cut_, closest)) return;
    const glm::dvec3 offset = p_ - closest.point;
    const double square = glm::dot(offset, offset);
    if (square > bestSquare_ || (square == bestSquare_ && found_ && index > nearest_.triangle)) return;
    found_ = true;
    bestSquare_ = square;
    bound_ = roundUp(std::sqrt(square));
    nearest_.triangle = index;
    nearest_.point = closest.point;
    nearest_.onFace = closest.onFace;
  }

  const TriangleBvh& tree_;
  const glm::dvec3& p_;
  const Sections* const cut_;
  MeshPoint& nearest_;
  double bestSquare_;
  float bound_;
  const Float4 rounding_;
  bool found_ = false;
  std::uint64_t tested_ = 0;
};

void noteWork(std::uint64_t nodes, std::uint64_t triangles) {
  ++queryWork.queries;
  queryWork.nodes += nodes;
  queryWork.triangles += triangles;
}

}  // namespace

TriangleBvh::TriangleBvh(const assets::Mesh& mesh, int threads) : mesh_(&mesh) {
  const std::size_t count = mesh.triangles.size();
  ASSERT(count <= kLeafFirstMask);
  if (count == 0) return;
  const int workers = workersFor(count, threads);
  extent_ = extentOf(mesh, workers);
  BuiltTree built = buildTree(mesh, extent_.centre, workers);
  nodes_ = std::move(built.nodes);
  nodeCount_ = built.nodeCount;
  order_ = std::move(built.order);

  ASSERT(nodeCount_ > 0 && order_.size() == count);
  ASSERT(depth() <= kMaxDepth);
  BvhFit(mesh, {nodes_.get(), nodeCount_}, order_, extent_).fitSlabs(workers);
}

void TriangleBvh::refit(int threads) {
  ASSERT(mesh_->triangles.size() == order_.size());
  if (empty()) return;
  BvhFit(*mesh_, {nodes_.get(), nodeCount_}, order_, extent_).refit(workersFor(order_.size(), threads));
}

bool TriangleBvh::closestPoint(const glm::dvec3& p, double maxDistance, MeshPoint& nearest,
                               const Sections* cut) const {
  if (empty()) return false;
  const glm::dvec3 q = p - extent_.centre;
  const NearBoxes near(q, extent_.largest + glm::length(q));
  NearestSearch search(*this, p, maxDistance, cut, nearest);
  std::uint64_t nodes = 0;
  BvhStack stack;
  PendingNode next{0, 0.0f};
  do {
    if (next.bound > search.bound()) continue;
    if ((next.child & kLeafBit) == 0) {
      ++nodes;
      const Node& node = nodes_[next.child];
      alignas(16) float bounds[4];
      const int mask = near.within(node, search.bound(), bounds);
      if (mask != 0) stack.pushOrdered(node.child, bounds, mask);
      continue;
    }
    search.test(order_.data() + (next.child & kLeafFirstMask), leafCount(next.child));
  } while (stack.pop(next));
  noteWork(nodes, search.tested());
  return search.finish();
}

bool TriangleBvh::closestPointAmong(std::span<const std::uint32_t> triangles, const glm::dvec3& p,
                                    double maxDistance, MeshPoint& nearest) const {
  NearestSearch search(*this, p, maxDistance, nullptr, nearest);
  for (std::size_t i = 0; i < triangles.size(); i += 4)
    search.test(triangles.data() + i,
                static_cast<std::uint32_t>(std::min<std::size_t>(4, triangles.size() - i)));
  noteWork(0, search.tested());
  return search.finish();
}

NearLeaf TriangleBvh::nearestLeaf(const glm::dvec3& p, double reach) const {
  if (empty()) return {reach, kNoTriangle};
  const glm::dvec3 q = p - extent_.centre;
  const NearBoxes near(q, extent_.largest + glm::length(q));
  float bound = roundUp(reach);
  std::uint32_t leaf = kEmptyChild;
  std::uint64_t nodes = 0;
  BvhStack stack;
  PendingNode next{0, 0.0f};
  do {
    if (next.bound > bound) continue;
    if ((next.child & kLeafBit) != 0) {
      leaf = next.child;
      bound = next.bound;
      continue;
    }
    ++nodes;
    const Node& node = nodes_[next.child];
    alignas(16) float bounds[4];
    const int mask = near.within(node, bound, bounds);
    if (mask != 0) stack.pushOrdered(node.child, bounds, mask);
  } while (stack.pop(next));
  noteWork(nodes, 0);
  if (leaf == kEmptyChild) return {reach, kNoTriangle};
  return {std::max(0.0, static_cast<double>(bound) - coordinateRounding(p)), order_[leaf & kLeafFirstMask]};
}

bool TriangleBvh::sweepBall(const glm::dvec3& from, const glm::dvec3& motion, double radius, double tolerance,
                            MeshBallHit& hit, const Sections* cut) const {
  if (empty()) return false;
  const glm::dvec3 origin = from - extent_.centre;
  const double largest = extent_.largest + radius + glm::length(origin) + glm::length(motion);
  const SweptBall ball(origin, motion, radius + tolerance, largest);
  TriangleSweep sweep(*this, from, motion, radius, tolerance, coordinateRounding(from), cut, hit);
  std::uint64_t nodes = 0;
  BvhStack stack;
  PendingNode next{0, 0.0f};
  do {
    if (next.bound > sweep.latest()) continue;
    if ((next.child & kLeafBit) == 0) {
      ++nodes;
      const Node& node = nodes_[next.child];
      alignas(16) float bounds[4];
      const int mask = ball.enter(node, sweep.latest(), bounds);
      stack.pushOrdered(node.child, bounds, mask);
      continue;
    }
    const std::uint32_t* const triangles = order_.data() + (next.child & kLeafFirstMask);
    const std::uint32_t count = leafCount(next.child);
    sweep.test(haptics::leafTriangles(*mesh_, triangles, count, from), triangles, count);
  } while (stack.pop(next));
  noteWork(nodes, sweep.tested());
  return sweep.found();
}

template <typename Visit>
void TriangleBvh::forEachInBox(const assets::Bounds& box, Visit&& visit) const {
  if (empty()) return;
  Float4 low[3], high[3];
  for (int axis = 0; axis < 3; ++axis) {
    low[axis] = Float4(roundDown(box.min[axis] - extent_.centre[axis]));
    high[axis] = Float4(roundUp(box.max[axis] - extent_.centre[axis]));
  }
  BvhStack stack;
  PendingNode next{0, 0.0f};
  do {
    if ((next.child & kLeafBit) == 0) {
      const Node& node = nodes_[next.child];
      int mask = 15;
      for (int axis = 0; axis < 3; ++axis) {
        mask &= lessEqualMask(Float4::load(node.low[axis]), high[axis]);
        mask &= lessEqualMask(low[axis], Float4::load(node.high[axis]));
      }
      constexpr float kNone[4] = {0.0f, 0.0f, 0.0f, 0.0f};
      stack.pushOrdered(node.child, kNone, mask);
      continue;
    }
    const std::uint32_t first = next.child & kLeafFirstMask;
    for (std::uint32_t i = 0; i < leafCount(next.child); ++i) visit(order_[first + i]);
  } while (stack.pop(next));
}

int TriangleBvh::signedCrossings(const glm::dvec3& from, const glm::dvec3& to, const Sections* cut) const {
  if (empty()) return 0;
  const glm::dvec3 direction = to - from, origin = from - extent_.centre;
  const SweptPoint slabs(origin, direction, 0.0,
                         extent_.largest + glm::length(origin) + glm::length(direction));
  int crossings = 0;
  BvhStack stack;
  PendingNode next{0, 0.0f};
  do {
    if ((next.child & kLeafBit) == 0) {
      const Node& node = nodes_[next.child];
      alignas(16) float bounds[4];
      const int mask = slabs.enter(node, 1.0f, bounds);
      stack.pushOrdered(node.child, bounds, mask);
      continue;
    }
    const std::uint32_t first = next.child & kLeafFirstMask;
    for (std::uint32_t i = 0; i < leafCount(next.child); ++i) {
      crossings += crossing(from, direction, triangle(order_[first + i]), cut);
    }
  } while (stack.pop(next));
  return crossings;
}

std::size_t TriangleBvh::gather(const assets::Bounds& box, std::span<std::uint32_t> found) const {
  std::size_t count = 0;
  forEachInBox(box, [&](std::uint32_t index) {
    if (count < found.size()) found[count] = index;
    ++count;
  });
  return count;
}

int TriangleBvh::depth() const {
  if (empty()) return 0;
  // Children stand after their parents, so one forward pass suffices.
  std::vector<int> levels(nodeCount_, 1);
  int deepest = 1;
  for (std::size_t i = 0; i < nodeCount_; ++i) {
    for (const std::uint32_t child : nodes_[i].child) {
      if ((child & kLeafBit) != 0) continue;
      levels[child] = levels[i] + 1;
      deepest = std::max(deepest, levels[child]);
    }
  }
  return deepest;
}

}  // namespace tandem::haptics
