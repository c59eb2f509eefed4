#include <gtest/gtest.h>

#include <cmath>

#include "tests/haptics/hand_probe.h"

namespace tandem::test {
namespace {

using haptics::PartMotion;

TEST(MovingPart, GivesTheSameForceAsAStillOneThatTheHandMovesAgainst) {
  // A part that comes to the hand at 0.2 m/s, and a hand that goes to the part: only relative motion counts.
  SceneBuilder b;
  const PartId part = b.addPart(sphereMesh(0.02, 40), {}, 1.0);
  haptics::TickParameters p = springOnly();
  p.damping = 2.0;
  HandProbe still(b.scene, p), moving(b.scene, p);
  for (int i = 0; i < 60; ++i) {
    const double way = 2e-4 * i;
    still.at({0.001, 0.002, 0.026 - way});
    Pose pose;
    pose.position.z = way;
    moving.moved = {{part, pose, {{0.0, 0.0, 0.2}, {0.0, 0.0, 0.0}}}};
    moving.at({0.001, 0.002, 0.026});
    if (i == 0) continue;  // the still hand has no velocity yet
    EXPECT_LT(glm::length(still.out.hands[0].toHand.force - moving.out.hands[0].toHand.force), 1e-4) << i;
  }
  EXPECT_GT(still.out.hands[0].toHand.force.z, 3.0);
}

TEST(MovingPart, TurningPaddleTakesTheProxyAlong) {
  SceneBuilder b;
  const PartId part = b.addPart(boxMesh({0.2, 0.001, 0.05}), {}, 1.0);
  HandProbe hand(b.scene);
  hand.at({0.06, 0.004, 0.0});
  for (int i = 1; i <= 300; ++i) {
    const double angle = 0.004 * i;  // 4 rad/s
    const Pose pose{{0.0, 0.0, 0.0}, fromRotationVector({0.0, 0.0, angle})};
    hand.moved = {{part, pose, {{0.0, 0.0, 0.0}, {0.0, 0.0, 4.0}}}};
    hand.at({0.06, 0.004, 0.0});
    const glm::dvec3 inPart = transformPoint(inverse(pose), hand.out.worldFromProxy.position);
    ASSERT_GT(inPart.y, 0.0005) << i;  // never through the blade
  }
  EXPECT_GT(hand.out.contactCount, 0);
}

TEST(MovingPart, CarriesAToolThatSticksToIt) {
  SceneBuilder b;
  const PartId part = b.addPart(boxMesh({0.2, 0.2, 0.02}), {}, 1.0);
  b.scene.materials[0].staticFriction = b.scene.materials[0].dynamicFriction = 0.9;
  HandProbe hand(b.scene);
  hand.at({0.0, 0.0, 0.02});
  hand.to({0.0, 0.0, 0.008}, 1e-4);
  const glm::dvec3 before = hand.out.worldFromProxy.position;
  for (int i = 1; i <= 100; ++i) {
    hand.moved = {{part, {{1e-5 * i, 0.0, 0.0}, {1.0, 0.0, 0.0, 0.0}}, {{0.01, 0.0, 0.0}, glm::dvec3(0.0)}}};
    hand.at({0.0, 0.0, 0.008});
  }
  EXPECT_NEAR(hand.out.worldFromProxy.position.x - before.x, 1e-3, 1e-9);
  EXPECT_NEAR(hand.out.hands[0].toHand.force.x, 0.8, 1e-5);
  hand.moved = {};
}

TEST(MovingPart, ManyMovingPartsKeepTheTickRight) {
  SceneBuilder b;
  const std::uint32_t mesh = b.addMesh(boxMesh({0.01, 0.01, 0.01}));
  for (int i = 0; i < 400; ++i)
    b.addPart(mesh, {{0.02 * (i % 20), 0.02 * (i / 20), 0.0}, {1.0, 0.0, 0.0, 0.0}}, 0.1);
  HandProbe hand(b.scene);
  hand.at({0.1, 0.1, 0.02});
  for (int step = 1; step <= 20; ++step) {
    for (PartId i = 0; i < 400; ++i) {
      hand.moved.push_back({i, {{0.02 * (i % 20), 0.02 * (i / 20), 5e-4 * step}, {1.0, 0.0, 0.0, 0.0}}, {}});
    }
    hand.at({0.1, 0.1, 0.02});
  }
  EXPECT_EQ(hand.out.contactCount, 0);
  hand.to({0.1, 0.1, 0.013}, 5e-4);
  EXPECT_EQ(hand.out.contactCount, 1);
  EXPECT_EQ(hand.out.contacts[0].part, 5 * 20 + 5);
  EXPECT_NEAR(hand.out.hands[0].toHand.force.z, 800.0 * 0.002, 1e-5);
}

TEST(MovingPart, PutOntoTheToolIsNotFeltUntilTheToolHasLeftIt) {
  SceneBuilder b;
  const PartId part = b.addPart(boxMesh({0.04, 0.04, 0.04}), {{1.0, 0.0, 0.0}, {1.0, 0.0, 0.0, 0.0}}, 1.0);
  HandProbe hand(b.scene);
  hand.at({0.0, 0.0, 0.01});
  hand.commands = {{haptics::PartCommand::Kind::setPose, part, {}}};
  hand.at({0.0, 0.0, 0.01});
  EXPECT_EQ(hand.out.hands[0].toHand.force, glm::dvec3(0.0));
  hand.to({0.0, 0.0, 0.03}, 5e-4);
  EXPECT_EQ(hand.out.hands[0].toHand.force, glm::dvec3(0.0));
  hand.to({0.0, 0.0, 0.018}, 5e-4);
  EXPECT_NEAR(hand.out.hands[0].toHand.force.z, 1.6, 1e-5);
}

}  // namespace
}  // namespace tandem::test
