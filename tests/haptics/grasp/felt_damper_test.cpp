// The damping force that a hand feels while the part that it holds is in contact.

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "haptics/grasp/felt_damper.h"

namespace tandem::test {
namespace {

using haptics::FeltDamper;

constexpr double kDamping = 4.0, kChange = 0.05;  // N·s/m and N

/// W that a hand and a part together gain from a damper, of which the part is given everything.
double gained(const glm::dvec3& felt, const glm::dvec3& grip, const glm::dvec3& hand) {
  return glm::dot(felt, hand) - kDamping * glm::dot(grip - hand, grip);
}

TEST(FeltDamper, GainsNothingWhateverMovesWhere) {
  std::mt19937 random(3);
  std::normal_distribution<double> speed(0.0, 0.1);
  const auto velocity = [&] {
    const double x = speed(random), y = speed(random), z = speed(random);
    return glm::dvec3(x, y, z);
  };
  FeltDamper damper;
  double most = -std::numeric_limits<double>::infinity(), mostOfNothing = most;
  int lessened = 0;
  for (int i = 0; i < 100'000; ++i) {
    const glm::dvec3 grip = velocity(), hand = velocity(), whole = kDamping * (grip - hand);
    const bool touches = i / 100 % 3 != 0;
    const glm::dvec3 felt = damper.force(kDamping, grip, hand, touches, kChange);
    most = std::max(most, gained(felt, grip, hand));
    mostOfNothing = std::max(mostOfNothing, gained(glm::dvec3(0.0), grip, hand));
    lessened += felt != whole ? 1 : 0;
  }
  EXPECT_LE(most, 1e-15);
  EXPECT_GT(lessened, 60'000);
  EXPECT_GT(mostOfNothing, 1e-3);  // a hand that felt nothing of it would gain
}

TEST(FeltDamper, IsFeltWholeUnlessAPartTouches) {
  const glm::dvec3 grip(0.3, 0.0, 0.1), hand(0.1, 0.2, 0.0);
  FeltDamper damper;
  EXPECT_EQ(damper.force(kDamping, grip, hand, false, kChange), kDamping * (grip - hand));
  EXPECT_EQ(damper.force(kDamping, grip, hand, true, 0.0), kDamping * (grip - hand));
}

TEST(FeltDamper, IsHardlyFeltWhereAWallStopsThePart) {
  const glm::dvec3 hand(0.0, 0.0, -0.1);
  FeltDamper damper;
  EXPECT_EQ(damper.force(kDamping, hand, hand, false, kChange), glm::dvec3(0.0));
  EXPECT_NEAR(damper.force(kDamping, glm::dvec3(0.0), hand, true, kChange).z, kChange, 1e-15);
}

TEST(FeltDamper, ComesAndGoesGradually) {
  const glm::dvec3 grip(0.1, 0.0, 0.0), hand(0.0);
  FeltDamper damper;
  double last = damper.force(kDamping, grip, hand, false, kChange).x, least = last;
  EXPECT_EQ(last, 0.4);
  for (const bool touches : {true, false})
    for (int i = 0; i < 10; ++i) {
      const double now = damper.force(kDamping, grip, hand, touches, kChange).x;
      EXPECT_LE(std::abs(now - last), kChange + 1e-15);
      least = std::min(least, now);
      last = now;
    }
  EXPECT_NEAR(least, kChange, 1e-15);
  EXPECT_EQ(last, 0.4);
}

}  // namespace
}  // namespace tandem::test
