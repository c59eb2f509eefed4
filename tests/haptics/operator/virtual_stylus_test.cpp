#include "haptics/operator/virtual_stylus.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

namespace tandem::haptics {
namespace {

constexpr double kStylusTick = 1e-3;

TEST(PoseFilter, FollowsTheCriticallyDampedStepResponse) {
  const double time = 0.03;
  PoseFilter filter{Pose{}};
  const Pose target{{0.01, 0.0, 0.0}, fromRotationVector({0.0, 0.0, 0.5})};
  for (int i = 1; i <= 300; ++i) {
    filter.step(target, time, 1e9, kStylusTick);
    const double s = i * kStylusTick / time;
    const double left = (1.0 + s) * std::exp(-s);
    ASSERT_NEAR(filter.pose().position.x, 0.01 * (1.0 - left), 1e-12);
    ASSERT_NEAR(rotationVector(filter.pose().orientation).z, 0.5 * (1.0 - left), 1e-9);
  }
}

TEST(PoseFilter, NeverExceedsItsGreatestSpeed) {
  PoseFilter filter{Pose{}};
  double fastest = 0.0;
  for (int i = 0; i < 3000; ++i) {
    filter.step(Pose{{3.0, 4.0, 0.0}, glm::dquat(1.0, 0.0, 0.0, 0.0)}, 0.03, 2.0, kStylusTick);
    fastest = std::max(fastest, glm::length(filter.twist().linear));
  }
  EXPECT_LE(fastest, 2.0 + 1e-9);
  EXPECT_GT(fastest, 1.9);
  EXPECT_NEAR(glm::length(filter.pose().position), 5.0, 1e-3) << "and still arrives";
}

TEST(VirtualStylus, SmoothsTheStepsOfASixtyHertzMouse) {
  VirtualStylus stylus;
  ASSERT_TRUE(stylus.open().ok());
  double largestStep = 0.0, travel = 0.0;
  glm::dvec3 last{0.0, 0.0, 0.0};
  for (int i = 0; i < 1000; ++i) {
    if (i % 16 == 0) stylus.setTarget({0.1 * i * kStylusTick, 0.0, 0.0});  // 1.6 mm every 16 ms
    stylus.poll(i * kStylusTick);
    stylus.apply({});
    const glm::dvec3 here = stylus.hand().devicePose().position;
    largestStep = std::max(largestStep, glm::length(here - last));
    travel += glm::length(here - last);
    last = here;
  }
  EXPECT_LT(largestStep, 2.0 * 0.1 * kStylusTick) << "the mean step is 0.1 mm";
  EXPECT_GT(travel, 0.08);
}

TEST(VirtualStylus, ArrivesAtTheMouseAndCarriesItsButtons) {
  VirtualStylus stylus;
  ASSERT_TRUE(stylus.open().ok());
  stylus.setTarget({0.05, -0.02, 0.01}, glm::dquat(2.0, 0.0, 0.0, 0.0));
  stylus.setButtons(2);
  DeviceSample sample;
  for (int i = 0; i < 2000; ++i) {
    sample = stylus.poll(i * kStylusTick);
    stylus.apply({});
  }
  EXPECT_LT(glm::length(sample.worldFromDevice.position - glm::dvec3(0.05, -0.02, 0.01)), 1e-3);
  EXPECT_EQ(sample.buttons, 2u);
}

TEST(VirtualStylus, RestsOnAWallWhileTheMouseIsBehindIt) {
  VirtualStylus stylus;
  ASSERT_TRUE(stylus.open().ok());
  stylus.setTarget({0.005, 0.0, 0.0});
  double deepest = 0.0, quietest = 1.0, loudest = -1.0;
  for (int i = 0; i < 4000; ++i) {
    const DeviceSample sample = stylus.poll(i * kStylusTick);
    const double depth = std::max(0.0, sample.worldFromDevice.position.x);
    stylus.apply({{-800.0 * depth - (depth > 0.0 ? 1.0 * sample.twist.linear.x : 0.0), 0.0, 0.0}, {}});
    const double x = stylus.hand().devicePose().position.x;
    deepest = std::max(deepest, x);
    if (i > 3000) quietest = std::min(quietest, x), loudest = std::max(loudest, x);
  }
  EXPECT_LT(deepest, 3.0e-3);
  EXPECT_GT(loudest, 0.3e-3) << "it does press";
  EXPECT_LT(loudest - quietest, 0.2e-3) << "without buzzing";
}

TEST(VirtualStylus, IgnoresTargetsThatAreNotANumber) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  VirtualStylus stylus;
  ASSERT_TRUE(stylus.open().ok());
  stylus.setTarget({nan, 0.0, 0.0});
  stylus.setTarget({0.0, 0.0, 0.0}, glm::dquat(0.0, 0.0, 0.0, 0.0));
  stylus.setTarget({0.0, 0.0, 0.0}, glm::dquat(nan, 0.0, 0.0, 0.0));
  for (int i = 0; i < 100; ++i) EXPECT_TRUE(stylus.poll(i * kStylusTick).valid);
}

}  // namespace
}  // namespace tandem::haptics
