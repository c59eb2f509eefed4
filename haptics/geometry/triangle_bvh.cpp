#include "haptics/geometry/triangle_bvh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "haptics/base/simd4.h"
#include "haptics/geometry/leaf_slab.h"
#include "haptics/geometry/outward.h"
#include "haptics/geometry/triangle_filter.h"

namespace tandem::haptics {
namespace {

constexpr int kStackSize = 3 * TriangleBvh::kMaxDepth + 4;

/// A node (or leaf) still to be visited, with a lower bound of its result.
struct Pending {
  std::uint32_t child;
  float bound;
};

class Stack {
 public:
  bool pop(Pending& next) {
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
  std::array<Pending, kStackSize> entries_;
  int size_ = 0;
};

/// A motion in the form of four-wide slab tests.
class Slabs {
 public:
  /// Boxes are inflated by `radius` plus an allowance for float rounding: of the origin, of the differences
  /// and of t, each a few units in the last place of `largest`, the largest length involved.
  Slabs(const glm::dvec3& origin, const glm::dvec3& motion, double radius, double largest) {
    const Float4 inflate(roundUp(radius + largest * 0x1p-20));
    for (int axis = 0; axis < 3; ++axis) {
      const Float4 start(static_cast<float>(origin[axis]));
      above_[axis] = start + inflate;
      below_[axis] = start - inflate;
      const double least = largest * 0x1p-60;
      const double step = std::abs(motion[axis]) > least ? motion[axis] : std::copysign(least, motion[axis]);
      inverse_[axis] = Float4(static_cast<float>(std::clamp(1.0 / step, -1e30, 1e30)));
    }
  }

  /// Which children the motion meets before `latest` (a fraction of the motion), with lower bounds of the
  /// times.
  int enter(const TriangleBvh::Node& node, float latest, float* bounds) const {
    Float4 enter, leave(latest);
    for (int axis = 0; axis < 3; ++axis) {
      const Float4 t0 = (Float4::load(node.low[axis]) - above_[axis]) * inverse_[axis];
      const Float4 t1 = (Float4::load(node.high[axis]) - below_[axis]) * inverse_[axis];
      enter = max(enter, min(t0, t1));
      leave = min(leave, max(t0, t1));
    }
    enter = enter * Float4(1.0f - 0x1p-20f);
    enter.store(bounds);
    return lessEqualMask(enter, leave);
  }

 private:
  Float4 above_[3], below_[3], inverse_[3];  // inflated start; 1 / motion
};

/// A moving ball in the form of four-wide tests against boxes. Slabs of the inflated box are tight for a ball
/// smaller than the box. For a larger ball, the distance to the content of a box is at least
///     u . (x - c) - max over the contents of u . (y - c)
/// for every unit vector u; u points from roughly the nearest point to the ball's centre. The box bounds the
/// maximum, and for a leaf of nearly flat triangles so does its slab: u = a N + w, a >= 0.
class MovingBall {
 public:
  MovingBall(const glm::dvec3& origin, const glm::dvec3& motion, double radius, double largest)
      : slabs_(origin, motion, radius, largest),
        reach_(roundUp(radius + largest * 0x1p-19)),
        far_(glm::length(motion) > radius) {
    const auto four = [](const glm::dvec3& v) {
      return Vec4{Float4(static_cast<float>(v.x)), Float4(static_cast<float>(v.y)),
                  Float4(static_cast<float>(v.z))};
    };
    origin_ = four(origin);
    motion_ = four(motion);
  }

  /// Which children the ball may meet before `latest`, with lower bounds of the times as the visiting order.
  /// A bound is negative where the start is within reach already. The deepest such child comes first, because
  /// it most likely holds an early hit that excludes the others.
  int enter(const TriangleBvh::Node& node, float latest, float* bounds) const {
    int mask = 15;
    if (far_) {
      mask = slabs_.enter(node, latest, bounds);
      if (mask == 0) return 0;
    } else {
      Float4().store(bounds);
    }
    const Vec4 low = node.lows(), high = node.highs();
    const Float4 half(0.5f);
    const Vec4 centre = (low + high) * half, extent = (high - low) * half, d = origin_ - centre;
    const Slab4 slab = unpackSlabs(node.slab, extent);
    // Roughly the nearest point: the foot on the slab's face, within the box.
    const Float4 least(1e-37f), inverse = roughReciprocal(max(dot(slab.normal, slab.normal), least));
    const Float4 height = max(dot(slab.normal, d) - slab.offset, Float4()) * inverse;
    const Vec4 foot = d - slab.normal * height;
    const Vec4 u = d - min(max(foot, Vec4{} - extent), extent);
    const Float4 along = max(dot(u, slab.normal), Float4()) * inverse;
    const Vec4 rest = u - slab.normal * along;
    const Float4 length = sqrt(dot(u, u));
    // All lengths are times |u|: the ball's gap at the start, and the approach over the whole motion.
    const Float4 gap = dot(u, d) - along * slab.offset - dot(abs(rest), extent) - reach_ * length;
    const Float4 nearing = Float4() - dot(u, motion_);
    const Float4 t = gap * roughReciprocal(max(nearing, least)) * Float4(1.0f - 0x1p-10f);
    const int met = lessEqualMask(gap, Float4()) | lessEqualMask(t, Float4(latest));
    selectLessEqual(gap, Float4(), gap, max(t, Float4::load(bounds))).store(bounds);
    return mask & met;
  }

 private:
  Slabs slabs_;
  Vec4 origin_, motion_;
  Float4 reach_;
  bool far_;  // the slabs add nothing for a motion shorter than the ball
};

/// Four vectors one by one.
class Directions {
 public:
  explicit Directions(const Vec4& v) {
    v.x.store(x_);
    v.y.store(y_);
    v.z.store(z_);
  }
  glm::dvec3 operator[](std::size_t i) const { return {x_[i], y_[i], z_[i]}; }

 private:
  alignas(16) float x_[4], y_[4], z_[4];
};

/// Whether a point that moves from `from` by `way` certainly stays further than `reach` from a triangle: the
/// bound of triangle_filter.h in double along `away`, which need not be a unit vector.
bool passesBy(const glm::dvec3& away, const glm::dvec3& from, const glm::dvec3& way, double reach,
              const Triangle& t) {
  const double least =
      std::min({glm::dot(away, from - t.a), glm::dot(away, from - t.b), glm::dot(away, from - t.c)}) +
      std::min(0.0, glm::dot(away, way));
  return least > 0.0 && least * least > reach * reach * glm::dot(away, away);
}

/// passesBy() along the triangle's normal, which excludes the neighbours in a plane along which a point
/// glides.
bool passesAbove(const glm::dvec3& from, const glm::dvec3& way, double reach, const Triangle& t) {
  const glm::dvec3 normal = areaVector(t);
  return passesBy(glm::dot(normal, from - t.a) > 0.0 ? normal : -normal, from, way, reach, t);
}

/// +1 where the segment leaves through the triangle's outside, -1 where it enters, 0 where it misses.
int crossing(const glm::dvec3& from, const glm::dvec3& direction, const Triangle& t) {
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
  return slope > 0.0 ? 1 : -1;
}

}  // namespace

Triangles4 TriangleBvh::gather4(std::uint32_t first, std::uint32_t count, const glm::dvec3& origin) const {
  const glm::dvec3* corners[3][4];
  for (std::uint32_t i = 0; i < 4; ++i) {
    const auto& t = mesh_->triangles[order_[first + std::min(i, count - 1)]];
    for (std::size_t k = 0; k < 3; ++k) corners[k][i] = &mesh_->positions[t[k]];
  }
  return {gatherRelative(corners[0], origin), gatherRelative(corners[1], origin),
          gatherRelative(corners[2], origin)};
}

bool TriangleBvh::closestPoint(const glm::dvec3& p, double maxDistance, MeshPoint& nearest) const {
  if (empty()) return false;
  // The query point is an interval of two floats around the true one, so that the distance of a box is never
  // overestimated. The factor covers the rounding of the sum of squares.
  constexpr float kBelow = 1.0f - 16.0f * std::numeric_limits<float>::epsilon();
  Float4 pointLow[3], pointHigh[3];
  const glm::dvec3 q = p - centre_;
  for (int axis = 0; axis < 3; ++axis) {
    pointLow[axis] = Float4(roundDown(q[axis]));
    pointHigh[axis] = Float4(roundUp(q[axis]));
  }
  double bestSquare = maxDistance * maxDistance;
  float bound = roundUp(bestSquare), distanceBound = roundUp(maxDistance);
  const Float4 rounding(roundUp(coordinateRounding(p)));
  bool found = false;
  Stack stack;
  Pending next{0, 0.0f};
  do {
    if (next.bound > bound) continue;
    if ((next.child & kLeafBit) == 0) {
      const Node& node = nodes_[next.child];
      Float4 square;
      for (int axis = 0; axis < 3; ++axis) {
        const Float4 below = Float4::load(node.low[axis]) - pointHigh[axis];
        const Float4 above = pointLow[axis] - Float4::load(node.high[axis]);
        const Float4 d = max(max(below, above), Float4());
        square = square + d * d;
      }
      square = square * Float4(kBelow);
      alignas(16) float bounds[4];
      square.store(bounds);
      stack.pushOrdered(node.child, bounds, lessEqualMask(square, Float4(bound)));
      continue;
    }
    const std::uint32_t first = next.child & kLeafFirstMask, count = leafCount(next.child);
    const Triangles4 corners = gather4(first, count, p);
    const DistanceBound4 least = boundDistance(corners, awayFrom(corners), Vec4{});
    const int far = lessMask(Float4(distanceBound) + rounding, least.distance - least.error);
    for (std::uint32_t i = 0; i < count; ++i) {
      if ((far >> i & 1) != 0) continue;
      const std::uint32_t index = order_[first + i];
      const TrianglePoint closest = closestPointOnTriangle(p, triangle(index));
      const glm::dvec3 offset = p - closest.point;
      const double square = glm::dot(offset, offset);
      // A tie goes to the lower index, so the result does not depend on the order of visits.
      if (square > bestSquare || (square == bestSquare && found && index > nearest.triangle)) continue;
      found = true;
      bestSquare = square;
      bound = roundUp(square);
      distanceBound = roundUp(std::sqrt(square));
      nearest.triangle = index;
      nearest.point = closest.point;
      nearest.onFace = closest.onFace;
    }
  } while (stack.pop(next));
  if (found) nearest.distance = std::sqrt(bestSquare);
  return found;
}

bool TriangleBvh::sweepBall(const glm::dvec3& from, const glm::dvec3& motion, double radius, double tolerance,
                            MeshBallHit& hit) const {
  if (empty()) return false;
  const glm::dvec3 origin = from - centre_;
  const double largest = extent_ + radius + glm::length(origin) + glm::length(motion);
  const MovingBall ball(origin, motion, radius + tolerance, largest);
  const Vec4 motion4{Float4(static_cast<float>(motion.x)), Float4(static_cast<float>(motion.y)),
                     Float4(static_cast<float>(motion.z))};
  const double closest = radius + tolerance + coordinateRounding(from);
  const Float4 reach(roundUp(closest));
  bool found = false;
  Stack stack;
  Pending next{0, 0.0f};
  float latest = roundUp(hit.t * (1.0 + 0x1p-20));
  do {
    if (next.bound > latest) continue;
    if ((next.child & kLeafBit) == 0) {
      const Node& node = nodes_[next.child];
      alignas(16) float bounds[4];
      const int mask = ball.enter(node, latest, bounds);
      stack.pushOrdered(node.child, bounds, mask);
      continue;
    }
    const std::uint32_t first = next.child & kLeafFirstMask, count = leafCount(next.child);
    const Triangles4 corners = gather4(first, count, from);
    const Vec4 away = awayFrom(corners);
    const DistanceBound4 bound = boundDistance(corners, away, motion4);
    const Float4 least = bound.distance + min(bound.slope * Float4(latest), Float4());
    const int missed = lessMask(reach, least - bound.error);
    if (missed == 15) continue;
    const Directions passing(awayInPassing(corners, away, motion4, Float4(latest)));
    for (std::uint32_t i = 0; i < count; ++i) {
      if ((missed >> i & 1) != 0) continue;
      const std::uint32_t index = order_[first + i];
      const Triangle t = triangle(index);
      const glm::dvec3 way = motion * double{latest};
      if (passesBy(passing[i], from, way, closest, t) || passesAbove(from, way, closest, t)) continue;
      BallHit candidate;
      candidate.t = hit.t;
      if (!haptics::sweepBall(from, motion, radius, tolerance, t, candidate)) continue;
      if (found && candidate.t == hit.t) {
        const double now = glm::dot(candidate.normal, motion), best = glm::dot(hit.normal, motion);
        if (now > best || (now == best && index > hit.triangle)) continue;
      }
      found = true;
      static_cast<BallHit&>(hit) = candidate;
      hit.triangle = index;
      latest = roundUp(hit.t * (1.0 + 0x1p-20));
    }
  } while (stack.pop(next));
  return found;
}

template <typename Visit>
void TriangleBvh::forEachInBox(const assets::Bounds& box, Visit&& visit) const {
  if (empty()) return;
  Float4 low[3], high[3];
  for (int axis = 0; axis < 3; ++axis) {
    low[axis] = Float4(roundDown(box.min[axis] - centre_[axis]));
    high[axis] = Float4(roundUp(box.max[axis] - centre_[axis]));
  }
  Stack stack;
  Pending next{0, 0.0f};
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

int TriangleBvh::signedCrossings(const glm::dvec3& from, const glm::dvec3& to) const {
  if (empty()) return 0;
  const glm::dvec3 direction = to - from, origin = from - centre_;
  const Slabs slabs(origin, direction, 0.0, extent_ + glm::length(origin) + glm::length(direction));
  int crossings = 0;
  Stack stack;
  Pending next{0, 0.0f};
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
      crossings += crossing(from, direction, triangle(order_[first + i]));
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
