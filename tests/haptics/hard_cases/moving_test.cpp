// Parts that others move against a tool: exact proxies, never crossed, and what happens when there is no
// room.

#include <gtest/gtest.h>

#include <cmath>

#include <glm/geometric.hpp>

#include "tests/haptics/hand_probe.h"

namespace tandem::test {
namespace {

constexpr glm::dquat kNoTurn{1.0, 0.0, 0.0, 0.0};

class MovingAtScale : public testing::TestWithParam<double> {
 protected:
  double s() const { return GetParam(); }
  haptics::TickParameters parameters() const { return springOnly(1000.0 / s()); }
};

TEST_P(MovingAtScale, AFaceThatComesOrGrazesHoldsTheProxyExactly) {
  for (const double speed : {0.01, 0.1, 1.0}) {
    for (const glm::dvec3& way :
         {glm::dvec3(0.0, 0.0, 1.0), glm::dvec3(0.6, 0.0, 0.8), glm::dvec3(1.0, 0.0, 0.01)}) {
      SceneBuilder b;
      b.addPart(boxMesh(s() * glm::dvec3(0.4, 0.4, 0.1)), {}, 1.0);
      HandProbe hand(b.scene, parameters());
      const glm::dvec3 tool = s() * glm::dvec3(0.01, 0.02, 0.0501);
      hand.at(tool);
      const double step = speed * hand.parameters.dt;
      for (int i = 1; i <= 60; ++i) {
        const glm::dvec3 at = s() * step * i * way;
        hand.moved = {{0, {at, kNoTurn}, {s() * speed * way, glm::dvec3(0.0)}}};
        hand.at(tool);
        const double surface = 0.05 * s() + at.z, depth = std::max(0.0, surface - tool.z);
        const glm::dvec3 proxy = hand.out.worldFromProxy.position;
        ASSERT_NEAR(proxy.z, std::max(surface, tool.z), 1e-8 * s()) << speed << ' ' << way.x << ' ' << i;
        ASSERT_NEAR(proxy.x, tool.x, 1e-8 * s());
        ASSERT_NEAR(hand.out.hands[0].toHand.force.z, 1000.0 / s() * depth, 1e-5);
      }
    }
  }
}

TEST_P(MovingAtScale, ATurningFaceHoldsTheProxyAtTheNearestPointOfIt) {
  SceneBuilder b;
  b.addPart(boxMesh(s() * glm::dvec3(0.4, 0.4, 0.1)), {}, 1.0);
  HandProbe hand(b.scene, parameters());
  const glm::dvec3 tool = s() * glm::dvec3(0.02, 0.01, 0.049);
  hand.at(s() * glm::dvec3(0.02, 0.01, 0.06));
  hand.to(tool, 1e-3 * s());
  for (int i = 1; i <= 300; ++i) {
    const double angle = 0.002 * i;  // 2 rad/s
    const Pose pose{glm::dvec3(0.0), fromRotationVector({0.0, angle, 0.0})};
    hand.moved = {{0, pose, {glm::dvec3(0.0), {0.0, 2.0, 0.0}}}};
    hand.at(tool);
    const glm::dvec3 normal(std::sin(angle), 0.0, std::cos(angle));
    const double depth = 0.05 * s() - glm::dot(tool, normal);
    if (depth <= 0.0) continue;
    ASSERT_LT(glm::length(hand.out.worldFromProxy.position - (tool + depth * normal)), 1e-7 * s()) << i;
    ASSERT_LT(glm::length(hand.out.hands[0].toHand.force - 1000.0 / s() * depth * normal), 1e-4) << i;
  }
}

TEST_P(MovingAtScale, PlatesOfAnyThicknessNeverCrossAToolThatStandsStill) {
  for (const double thickness : {1e-3, 1e-4, 1e-5, 0.0}) {
    for (const double speed : {0.5, 2.0, 5.0}) {
      SceneBuilder b;
      b.addPart(thickness > 0.0 ? boxMesh(s() * glm::dvec3(0.1, 0.1, thickness)) : sheetMesh(0.1 * s(), 3),
                {}, 1.0);
      HandProbe hand(b.scene, parameters());
      const glm::dvec3 tool = s() * glm::dvec3(0.0021, 0.0013, 0.0103);
      hand.at(tool);
      const double step = speed * hand.parameters.dt;
      const int there = static_cast<int>(std::ceil(0.04 / step));
      for (int i = 1; i <= 2 * there; ++i) {
        const double z = s() * step * (i <= there ? i : 2 * there - i);
        const double velocity = s() * speed * (i <= there ? 1.0 : -1.0);
        hand.moved = {{0, {{0.0, 0.0, z}, kNoTurn}, {{0.0, 0.0, velocity}, glm::dvec3(0.0)}}};
        hand.at(tool);
        const double top = z + 0.5 * thickness * s();
        ASSERT_GT(hand.out.worldFromProxy.position.z, top) << thickness << ' ' << speed << ' ' << i;
        ASSERT_NEAR(hand.out.worldFromProxy.position.z, std::max(top, tool.z), 1e-8 * s());
      }
      EXPECT_EQ(hand.out.hands[0].toHand.force, glm::dvec3(0.0));
    }
  }
}

TEST_P(MovingAtScale, BetweenTwoBodiesTheForceIsBoundedAndTheToolFeelsAgainOnceTheyPart) {
  for (const double radius : {0.0, 0.003}) {
    SceneBuilder b;
    const PartId below = b.addPart(boxMesh(s() * glm::dvec3(0.1, 0.1, 0.1)), {}, 1.0);
    const PartId above = b.addPart(boxMesh(s() * glm::dvec3(0.1, 0.1, 0.1)), {}, 1.0);
    haptics::TickParameters p = parameters();
    p.toolRadius = radius * s();
    HandProbe hand(b.scene, p);
    bool flagged = false;
    double most = 0.0;
    for (int i = 0; i <= 200; ++i) {
      // The gap closes from 20 mm to -4 mm around a tool that stands still, and opens again.
      const double gap = 0.02 - 0.024 * (i <= 100 ? i : 200 - i) / 100.0;
      const double z = s() * (0.05 + 0.5 * gap);
      hand.moved = {{below, {{0.0, 0.0, -z}, kNoTurn}, {}}, {above, {{0.0, 0.0, z}, kNoTurn}, {}}};
      hand.at(glm::dvec3(0.0));
      flagged = flagged || (hand.out.flags & haptics::kFlagSqueezed) != 0;
      most = std::max(most, glm::length(hand.out.hands[0].toHand.force));
      ASSERT_TRUE(std::isfinite(hand.out.worldFromProxy.position.z));
    }
    EXPECT_TRUE(flagged) << radius;
    EXPECT_LE(most, 1000.0 * (0.002 + radius + 1e-6)) << radius;  // no deeper than they can push
    EXPECT_EQ(hand.out.hands[0].toHand.force, glm::dvec3(0.0)) << radius;
    hand.to(s() * glm::dvec3(0.0, 0.0, 0.011), s() * 1e-3);  // 1 mm deep for a point
    EXPECT_NEAR(hand.out.hands[0].toHand.force.z, -1000.0 * (0.001 + radius), 1e-4) << radius;
    hand.to(s() * glm::dvec3(0.0, 0.0, -0.011), s() * 1e-3);
    EXPECT_NEAR(hand.out.hands[0].toHand.force.z, 1000.0 * (0.001 + radius), 1e-4) << radius;
  }
}

TEST_P(MovingAtScale, APartThatTurnsOntoTheToolByThirtyDegreesArrivesAtTheCappedRate) {
  SceneBuilder b;
  b.addPart(boxMesh(s() * glm::dvec3(0.2, 0.2, 0.02)), {}, 1.0);
  haptics::TickParameters p = parameters();
  p.slewLimit = 400.0;
  HandProbe hand(b.scene, p);
  const glm::dvec3 tool = s() * glm::dvec3(0.04, 0.0, 0.02);
  for (int i = 0; i < 200; ++i) hand.at(tool);
  const double angle = -kPi / 6.0;
  const Pose pose{glm::dvec3(0.0), fromRotationVector({0.0, angle, 0.0})};
  const glm::dvec3 normal(std::sin(angle), 0.0, std::cos(angle));
  const double depth = 0.01 * s() - glm::dot(tool, normal);
  ASSERT_GT(depth, 0.0);
  for (int i = 1; i <= 60; ++i) {
    if (i == 1) hand.moved = {{0, pose, {}}};
    const double before = glm::length(hand.out.hands[0].toHand.force);
    hand.at(tool);
    EXPECT_LT(glm::length(hand.out.worldFromProxy.position - (tool + depth * normal)), 1e-7 * s()) << i;
    EXPECT_LE(glm::length(hand.out.hands[0].toHand.force), before + 0.4 + 1e-9) << i;
  }
  EXPECT_LT(glm::length(hand.out.hands[0].toHand.force - 1000.0 / s() * depth * normal), 1e-4);
}

TEST_P(MovingAtScale, FrictionCarriesAToolOnATurningPartWithoutSlip) {
  SceneBuilder b;
  b.addPart(boxMesh(s() * glm::dvec3(0.2, 0.2, 0.02)), {}, 1.0);
  b.scene.materials[0].staticFriction = b.scene.materials[0].dynamicFriction = 0.9;
  HandProbe hand(b.scene, parameters());
  const glm::dvec3 tool = s() * glm::dvec3(0.02, 0.0, 0.005);
  hand.at(s() * glm::dvec3(0.02, 0.0, 0.02));
  hand.to(tool, s() * 1e-4);
  const glm::dvec3 start = hand.out.worldFromProxy.position;
  for (int i = 1; i <= 100; ++i) {
    const double angle = 1e-3 * i;  // 1 rad/s: the tool lags by 2 mm at the end, within the cone of 4.5 mm
    const Pose pose{glm::dvec3(0.0), fromRotationVector({0.0, 0.0, angle})};
    hand.moved = {{0, pose, {glm::dvec3(0.0), {0.0, 0.0, 1.0}}}};
    hand.at(tool);
    ASSERT_LT(glm::length(hand.out.worldFromProxy.position - transformPoint(pose, start)), 1e-8 * s()) << i;
  }
}

INSTANTIATE_TEST_SUITE_P(Scales, MovingAtScale, testing::Values(1e-3, 1.0, 20.0));

}  // namespace
}  // namespace tandem::test
