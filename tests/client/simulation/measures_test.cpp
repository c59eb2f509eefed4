#include "client/simulation/measures.h"

#include <gtest/gtest.h>

#include <cmath>

namespace tandem::client {
namespace {

HandSample sample(double x, double force, bool still = true) {
  HandSample s;
  s.position = {x, 0, 0};
  s.force = {force, 0, 0};
  s.still = still;
  return s;
}

TEST(HandMeasures, FeltStiffnessIsTheSlopeOfForceAgainstTravel) {
  HandMeasures measures;
  for (int i = 0; i < 200; ++i) {
    HandSample s = sample(1e-5 * i, -830.0 * 1e-5 * i);
    s.pressing = true;
    measures.add(s);
  }
  EXPECT_NEAR(measures.feltStiffness(), 830.0, 1e-6);
}

TEST(HandMeasures, NothingPressedIsNoStiffness) {
  HandMeasures measures;
  for (int i = 0; i < 200; ++i) measures.add(sample(1e-5 * i, 1.0 * i));
  EXPECT_EQ(measures.feltStiffness(), 0.0);
}

TEST(HandMeasures, ForceStepIsTheLargestChangeIn20Milliseconds) {
  HandMeasures measures;
  for (int i = 0; i < 100; ++i) measures.add(sample(0, i < 50 ? 0.0 : std::min(1.0, (i - 50) * 0.025)));
  EXPECT_NEAR(measures.forceStep(), 0.5, 1e-9);  // 0.025 N a tick for 20 ticks
}

TEST(HandMeasures, HandoverExcessComparesWithTheSecondBefore) {
  HandMeasures smooth, kicked;
  for (int i = 0; i < 3000; ++i) {
    const double force = std::sin(i * 1e-3 * 6.0);
    if (i == 1500) smooth.roleChanged(), kicked.roleChanged();
    smooth.add(sample(0, force, false));
    kicked.add(sample(0, force - (i >= 1510 ? 0.4 : 0.0), false));  // the force falls there
  }
  EXPECT_LT(smooth.handoverExcess(), 0.02);
  EXPECT_NEAR(kicked.handoverExcess(), 0.4, 0.05);
}

TEST(HandMeasures, AnOscillationAtRestIsNotStable) {
  HandMeasures quiet, buzzing;
  std::vector<bool> still;
  for (int i = 0; i < 4000; ++i) {
    still.push_back(true);
    quiet.add(sample(1e-5 * std::sin(i * 0.3), 0.01));
    buzzing.add(sample(1e-3 * std::sin(i * 0.3), 0.01));
  }
  EXPECT_TRUE(quiet.stable(still));
  EXPECT_FALSE(buzzing.stable(still));
}

TEST(HandMeasures, AForceStepWhileEverybodyIsStillIsNotStable) {
  HandMeasures kicked;
  std::vector<bool> still;
  for (int i = 0; i < 4000; ++i) {
    still.push_back(true);
    kicked.add(sample(0, i >= 2000 ? 0.4 : 0.0));
  }
  EXPECT_FALSE(kicked.stable(still));
}

TEST(HandMeasures, DivergenceIsNotStable) {
  HandMeasures measures;
  std::vector<bool> moving;
  for (int i = 0; i < 100; ++i) {
    moving.push_back(false);
    measures.add(sample(i < 50 ? 0.0 : std::nan(""), 0.0, false));
  }
  EXPECT_FALSE(measures.stable(moving));
}

}  // namespace
}  // namespace tandem::client
