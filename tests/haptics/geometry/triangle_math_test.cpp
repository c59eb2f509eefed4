#include "haptics/geometry/triangle_math.h"

#include <gtest/gtest.h>

#include <random>

namespace tandem::haptics {
namespace {

TEST(SweepBall, APointBesideACornerMeetsTheFaceThatItsWayLeadsThrough) {
  const Triangle t{{0.23366798827419349, -0.53996830203400903, 0.19392797045872856},
                   {0.37054560053553165, -0.053045290731319528, 0.05962364210012764},
                   {0.66629331434973116, -0.25289000278167739, 0.53267241313327962}};
  const glm::dvec3 from(0.37054560007301907, -0.05304529835073752, 0.059623642355343294);
  const glm::dvec3 motion(-0.035688990091429396, -0.12695860713085505, 0.035018047200041653);
  const glm::dvec3 normal = glm::normalize(glm::cross(t.b - t.a, t.c - t.a));
  ASSERT_GT(glm::dot(normal, from - t.a), 0.0);
  ASSERT_LT(glm::dot(normal, from + motion - t.a), 0.0);
  const double skin = 2.88365e-9;
  BallHit hit;
  EXPECT_TRUE(sweepBall(from, motion, 0.5 * skin, 0.125 * skin, t, hit));
}

TEST(SweepBall, NoWayFromBesideAnEdgeLeadsThroughTheFace) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> unit(-1.0, 1.0), share(0.0, 1.0);
  const auto vector = [&] { return glm::dvec3(unit(random), unit(random), unit(random)); };
  const double skin = 2e-9;
  int tried = 0;
  for (int i = 0; i < 300'000; ++i) {
    const Triangle t{vector(), vector(), vector()};
    const glm::dvec3 area = glm::cross(t.b - t.a, t.c - t.a);
    if (glm::length(area) < 0.05) continue;
    const glm::dvec3 normal = glm::normalize(area), along = glm::normalize(t.b - t.a);
    // One skin from a corner or an edge, beyond it and above the face, so that the direction is all rounding.
    const glm::dvec3 outwards = glm::cross(along, normal);
    const double lean = share(random);
    const glm::dvec3 from = t.a + (t.b - t.a) * (i % 2 == 0 ? 0.0 : share(random)) +
                            skin * glm::normalize(normal * (0.1 + lean) + outwards * (1.0 - lean));
    // Down to a few skins under the face, somewhere within it.
    const double u = 0.1 + 0.4 * share(random), v = 0.1 + 0.4 * share(random);
    const glm::dvec3 to = t.a + (t.b - t.a) * u + (t.c - t.a) * v - 4.0 * skin * normal;
    BallHit hit;
    ASSERT_TRUE(sweepBall(from, to - from, 0.5 * skin, 0.125 * skin, t, hit)) << i;
    ++tried;
  }
  EXPECT_GT(tried, 100'000);
}

}  // namespace
}  // namespace tandem::haptics
