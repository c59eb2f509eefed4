// What the hand does itself is felt as it is; what others do to it grows at the capped rate. At three scales:
// lengths by s and stiffness by 1/s, so that forces are the same.

#include <gtest/gtest.h>

#include <cmath>

#include <glm/geometric.hpp>

#include "tests/haptics/hand_probe.h"

namespace tandem::test {
namespace {

constexpr double kCap = 0.4;  // N a tick
constexpr glm::dquat kUpright{1.0, 0.0, 0.0, 0.0};

class SlewAtScale : public testing::TestWithParam<double> {
 protected:
  double s() const { return GetParam(); }
  haptics::TickParameters parameters() const {
    haptics::TickParameters p = springOnly(1000.0 / s());
    p.slewLimit = 400.0;
    return p;
  }
  assets::Scene box(const Pose& pose = {}) const {
    SceneBuilder b;
    b.addPart(boxMesh(s() * glm::dvec3(0.1, 0.1, 0.1)), pose, 1.0);
    return b.scene;
  }
  Pose at(double x, double y, double z) const { return {s() * glm::dvec3(x, y, z), kUpright}; }
};

TEST_P(SlewAtScale, AStrokeAtFiveMetresASecondIsExactInEveryTick) {
  HandProbe hand(box(), parameters());
  hand.at(s() * glm::dvec3(0.0, 0.0, 0.07));
  for (int i = 0; i <= 10; ++i) {
    const double z = 0.07 - 0.005 * i;  // 20 to -30 mm
    hand.at(s() * glm::dvec3(0.001 * i, 0.0, z));
    EXPECT_NEAR(hand.out.hands[0].toHand.force.z, 1000.0 * std::max(0.0, 0.05 - z), 1e-5) << i;
    EXPECT_EQ(hand.out.flags & haptics::kFlagSlewLimited, 0u);
  }
  for (int i = 10; i >= 0; --i) {  // and on the way out nothing is held on to
    const double z = 0.07 - 0.005 * i;
    hand.at(s() * glm::dvec3(0.0, 0.0, z));
    EXPECT_NEAR(hand.out.hands[0].toHand.force.z, 1000.0 * std::max(0.0, 0.05 - z), 1e-5) << i;
  }
}

TEST_P(SlewAtScale, AConvexEdgeSnapsWithinATick) {
  HandProbe hand(box(), parameters());
  hand.at(s() * glm::dvec3(0.03, 0.0, 0.06));
  hand.to(s() * glm::dvec3(0.03, 0.0, 0.03), s() * 1e-3);
  ASSERT_NEAR(hand.out.hands[0].toHand.force.z, 20.0, 1e-5);
  hand.to(s() * glm::dvec3(0.06, 0.0, 0.03), s() * 1e-4);
  EXPECT_EQ(hand.out.hands[0].toHand.force, glm::dvec3(0.0));
  EXPECT_EQ(hand.out.flags & haptics::kFlagSlewLimited, 0u);
}

TEST_P(SlewAtScale, APartThatJumpsOntoTheToolArrivesAtTheCappedRate) {
  HandProbe hand(box(at(0.0, 0.0, -0.06)), parameters());
  const glm::dvec3 tool = s() * glm::dvec3(0.0, 0.0, 0.0);  // 10 mm over the box
  for (int i = 0; i < 200; ++i) hand.at(tool);
  glm::dvec3 last(0.0);
  for (int i = 0; i < 60; ++i) {
    if (i == 0) hand.moved = {{0, at(0.0, 0.0, -0.04), {s() * glm::dvec3(0.0, 0.0, 20.0), glm::dvec3(0.0)}}};
    hand.at(tool);
    EXPECT_NEAR(hand.out.worldFromProxy.position.z, s() * 0.01, s() * 1e-8);  // outside at once
    EXPECT_NEAR(hand.out.hands[0].toHand.force.z, std::min(10.0, kCap * (i + 1)), 1e-5) << i;
    last = hand.out.hands[0].toHand.force;
  }
  EXPECT_NEAR(last.z, 10.0, 1e-5);
}

TEST_P(SlewAtScale, AHandThatWithdrawsFromAPartThatIsArrivingIsNeverPulled) {
  HandProbe hand(box(at(0.0, 0.0, -0.06)), parameters());
  for (int i = 0; i < 10; ++i) hand.at(glm::dvec3(0.0));
  hand.moved = {{0, at(0.0, 0.0, -0.04), {}}};
  for (int i = 0; i < 10; ++i) hand.at(glm::dvec3(0.0));
  ASSERT_NEAR(hand.out.hands[0].toHand.force.z, 4.0, 1e-5);
  for (int i = 1; i <= 15; ++i) {
    const double before = hand.out.hands[0].toHand.force.z;
    hand.at(s() * glm::dvec3(0.0, 0.0, 0.001 * i));
    EXPECT_GE(hand.out.hands[0].toHand.force.z, 0.0) << i;
    EXPECT_LE(hand.out.hands[0].toHand.force.z, before)
        << i;  // a hand that goes away feels no more than before
  }
  EXPECT_EQ(hand.out.hands[0].toHand.force, glm::dvec3(0.0));
  hand.to(s() * glm::dvec3(0.0, 0.0, 0.005), s() * 1e-3);
  EXPECT_NEAR(hand.out.hands[0].toHand.force.z, 5.0, 1e-5);  // and on coming back the surface is where it is
}

TEST_P(SlewAtScale, APartThatIsTakenAwayLetsGoAtTheSameRate) {
  HandProbe hand(box(), parameters());
  hand.at(s() * glm::dvec3(0.0, 0.0, 0.06));
  hand.to(s() * glm::dvec3(0.0, 0.0, 0.047), s() * 1e-3);
  ASSERT_NEAR(hand.out.hands[0].toHand.force.z, 3.0, 1e-5);
  hand.commands = {{haptics::PartCommand::Kind::setPose, 0, at(1.0, 0.0, 0.0)}};
  for (int i = 1; i <= 10; ++i) {
    hand.at(s() * glm::dvec3(0.0, 0.0, 0.047));
    EXPECT_NEAR(hand.out.hands[0].toHand.force.z, std::max(0.0, 3.0 - kCap * i), 1e-5) << i;
  }
}

TEST_P(SlewAtScale, ASteadyMotionOfAPartIsFeltAsItIs) {
  HandProbe hand(box(at(0.0, 0.0, -0.06)), parameters());
  const Twist twist{s() * glm::dvec3(0.0, 0.0, 1.0), glm::dvec3(0.0)};
  hand.at(glm::dvec3(0.0));
  for (int i = 1; i <= 40; ++i) {
    hand.moved = {{0, at(0.0, 0.0, -0.06 + 0.001 * i), twist}};
    hand.at(glm::dvec3(0.0));
    EXPECT_NEAR(hand.out.hands[0].toHand.force.z, 1000.0 * std::max(0.0, 0.001 * i - 0.01), 1e-5) << i;
  }
}

TEST_P(SlewAtScale, RecoveryAfterALostSampleGrowsAtTheCappedRate) {
  HandProbe hand(box(), parameters());
  hand.at(s() * glm::dvec3(0.0, 0.0, 0.06));
  hand.to(s() * glm::dvec3(0.0, 0.0, 0.045), s() * 1e-3);
  ASSERT_NEAR(hand.out.hands[0].toHand.force.z, 5.0, 1e-5);
  hand.sample.valid = false;
  EXPECT_EQ(hand.tick().hands[0].toHand.force, glm::dvec3(0.0));
  for (int i = 1; i <= 20; ++i) {
    hand.at(s() * glm::dvec3(0.0, 0.0, 0.045));
    EXPECT_NEAR(hand.out.hands[0].toHand.force.z, std::min(5.0, kCap * i), 1e-5) << i;
  }
}

TEST_P(SlewAtScale, AChangedSettingDoesNotKick) {
  HandProbe hand(box(), parameters());
  hand.at(s() * glm::dvec3(0.0, 0.0, 0.06));
  hand.to(s() * glm::dvec3(0.0, 0.0, 0.045), s() * 1e-3);
  hand.parameters.stiffness *= 2.0;
  for (int i = 1; i <= 20; ++i) {
    hand.tick();
    EXPECT_NEAR(hand.out.hands[0].toHand.force.z, std::min(10.0, 5.0 + kCap * i), 1e-5) << i;
  }
}

INSTANTIATE_TEST_SUITE_P(Scales, SlewAtScale, testing::Values(1e-3, 1.0, 20.0));

}  // namespace
}  // namespace tandem::test
