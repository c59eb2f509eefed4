#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "haptics/geometry/bvh_stack.h"
#include "haptics/geometry/swept_boxes.h"

namespace tandem::test {
namespace {

using haptics::BvhStack;
using haptics::PendingNode;
using haptics::SweptBall;
using haptics::SweptPoint;
using haptics::TriangleBvh;

class SweptBoxes : public ::testing::Test {
 protected:
  double number() { return spread_(random_); }
  glm::dvec3 vector() { return {number(), number(), number()}; }
  /// Four boxes of random centres and sizes.
  TriangleBvh::Node node() {
    TriangleBvh::Node made{};
    for (int k = 0; k < 4; ++k) {
      const glm::dvec3 centre = vector(), half = 0.2 * glm::abs(vector());
      for (int axis = 0; axis < 3; ++axis) {
        made.low[axis][k] = static_cast<float>(centre[axis] - half[axis]);
        made.high[axis][k] = static_cast<float>(centre[axis] + half[axis]);
      }
    }
    return made;
  }
  /// m, from a point to one of the boxes.
  static double distance(const TriangleBvh::Node& node, int k, const glm::dvec3& p) {
    const glm::dvec3 low(node.low[0][k], node.low[1][k], node.low[2][k]),
        high(node.high[0][k], node.high[1][k], node.high[2][k]);
    return glm::length(p - glm::clamp(p, low, high));
  }

 private:
  std::mt19937 random_{1};
  std::uniform_real_distribution<double> spread_{-1.0, 1.0};
};

/// Whatever is met in truth is reported, and no later than it is met.
template <typename Swept>
void expectNothingMissed(const Swept& swept, const TriangleBvh::Node& node, const glm::dvec3& from,
                         const glm::dvec3& motion, double radius,
                         double (*distance)(const TriangleBvh::Node&, int, const glm::dvec3&)) {
  alignas(16) float bounds[4];
  const int mask = swept.enter(node, 1.0f, bounds);
  for (int k = 0; k < 4; ++k) {
    for (int i = 0; i <= 100; ++i) {
      const double t = 0.01 * i;
      if (distance(node, k, from + t * motion) > radius) continue;
      EXPECT_NE(mask >> k & 1, 0);
      EXPECT_LE(static_cast<double>(bounds[k]), t + 1e-9);
      break;
    }
  }
}

TEST_F(SweptBoxes, APointMissesNoBoxThatItMeets) {
  for (int run = 0; run < 500; ++run) {
    const TriangleBvh::Node boxes = node();
    const glm::dvec3 from = vector(), motion = 2.0 * vector();
    expectNothingMissed(SweptPoint(from, motion, 0.0, 4.0), boxes, from, motion, 0.0, &distance);
  }
}

TEST_F(SweptBoxes, ABallMissesNoBoxThatItMeetsShortOrFar) {
  for (const double length : {0.01, 2.0}) {
    for (int run = 0; run < 500; ++run) {
      const TriangleBvh::Node boxes = node();
      const glm::dvec3 from = vector(), motion = length * vector();
      expectNothingMissed(SweptBall(from, motion, 0.1, 4.0), boxes, from, motion, 0.1, &distance);
    }
  }
}

TEST_F(SweptBoxes, ABoxFarFromThePathIsNotMet) {
  TriangleBvh::Node boxes{};
  for (int axis = 0; axis < 3; ++axis) {
    for (int k = 0; k < 4; ++k) boxes.low[axis][k] = 5.0f, boxes.high[axis][k] = 6.0f;
  }
  const glm::dvec3 from(0.0), motion(1.0, 0.0, 0.0);
  alignas(16) float bounds[4];
  EXPECT_EQ(SweptPoint(from, motion, 0.0, 8.0).enter(boxes, 1.0f, bounds), 0);
  EXPECT_EQ(SweptBall(from, motion, 0.5, 8.0).enter(boxes, 1.0f, bounds), 0);
  EXPECT_EQ(SweptBall(from, motion, 2.0, 8.0).enter(boxes, 1.0f, bounds), 0);
}

TEST(BvhStack, PopsTheNearestChildFirstAndLeavesOutWhatIsMasked) {
  const std::uint32_t child[4] = {1, 2, 3, 4};
  const float bound[4] = {0.3f, 0.1f, 0.0f, 0.2f};
  BvhStack stack;
  stack.pushOrdered(child, bound, 0b1011);
  PendingNode next{};
  for (const std::uint32_t expected : {2u, 4u, 1u}) {
    ASSERT_TRUE(stack.pop(next));
    EXPECT_EQ(next.child, expected);
  }
  EXPECT_FALSE(stack.pop(next));
}

}  // namespace
}  // namespace tandem::test
