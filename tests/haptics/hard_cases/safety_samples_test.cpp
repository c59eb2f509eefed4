// Readings that are not there, stand still or jump: no force in that tick, none too strong after it, and a
// flag that says why.

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include <glm/geometric.hpp>

#include "haptics/body/virtual_coupling.h"
#include "haptics/safety/device_defaults.h"
#include "haptics/safety/sample_guard.h"
#include "tests/haptics/hand_probe.h"

namespace tandem::test {
namespace {

class SamplesAtScale : public testing::TestWithParam<double> {
 protected:
  double s() const { return GetParam(); }
  HandProbe pressing() const {
    haptics::TickParameters p = springOnly(1000.0 / s());
    p.slewLimit = 400.0;
    p.maxDeviceSpeed = 10.0 * s();
    SceneBuilder b;
    b.addPart(boxMesh(s() * glm::dvec3(0.1, 0.1, 0.1)));
    return HandProbe(b.scene, p);
  }
  glm::dvec3 inside(double depth) const { return s() * glm::dvec3(0.0, 0.0, 0.05 - depth); }
  void press(HandProbe& hand) const {
    hand.at(s() * glm::dvec3(0.0, 0.0, 0.06));
    hand.to(inside(0.003), s() * 1e-3);
    ASSERT_NEAR(hand.out.hands[0].toHand.force.z, 3.0, 1e-5);
  }
  /// From zero on, the force grows back to 3 N by 0.4 N a tick.
  void expectRecovery(HandProbe& hand) const {
    for (int i = 1; i <= 12; ++i) {
      hand.at(inside(0.003));
      EXPECT_NEAR(hand.out.hands[0].toHand.force.z, std::min(3.0, 0.4 * i), 1e-5) << i;
      EXPECT_EQ(hand.out.flags & (haptics::kFlagInvalidSample | haptics::kFlagFault), 0u);
    }
  }
};

TEST_P(SamplesAtScale, NanAndInfinityGiveNoForceAndTheNextGoodReadingRecovers) {
  HandProbe hand = pressing();
  press(hand);
  for (const double bad :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    hand.sample.worldFromDevice.position.x = bad;
    EXPECT_EQ(hand.tick().hands[0].toHand.force, glm::dvec3(0.0));
    EXPECT_TRUE(hand.out.flags & haptics::kFlagInvalidSample);
    hand.sample.worldFromDevice.position = inside(0.003);
    expectRecovery(hand);
  }
}

TEST_P(SamplesAtScale, ReadingsWhoseStampStandsStillGiveNoForce) {
  HandProbe hand = pressing();
  press(hand);
  const double stamp = hand.sample.time;
  int withForce = 0;
  for (int i = 0; i < 100; ++i) {
    hand.sample.time = stamp - hand.parameters.dt;  // tick() adds one period
    hand.tick();
    const bool force = hand.out.hands[0].toHand.force.z > 0.0;
    withForce += force ? 1 : 0;
    EXPECT_EQ(force, (hand.out.flags & haptics::kFlagStaleSample) == 0u);
    EXPECT_EQ(force, (hand.out.flags & haptics::kFlagInvalidSample) == 0u);
  }
  EXPECT_NEAR(withForce, 50, 1);
  hand.sample.time = stamp;
  expectRecovery(hand);
}

/// How many ticks of force a device gets whose stamps are, from now on, what `stamp(tick)` says; -1: all.
template <typename Stamp>
int ticksOfForce(HandProbe& hand, const Stamp& stamp, int ticks = 400) {
  int felt = 0;
  for (int i = 1; i <= ticks; ++i) {
    hand.sample.time = stamp(i) - hand.parameters.dt;  // tick() adds it
    hand.tick();
    const bool force = glm::length(hand.out.hands[0].toHand.force) > 0.0;
    EXPECT_EQ(force, (hand.out.flags & haptics::kFlagStaleSample) == 0u) << i;
    if (force && felt != i - 1) return -1;  // it came back
    felt += force ? 1 : 0;
  }
  return felt == ticks ? -1 : felt;
}

TEST_P(SamplesAtScale, StampsThatAreNoTimeOrGoBackwardsAreStaleAfterTheUsualTime) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const auto expectStale = [&](const char* what, const auto& stamp) {
    HandProbe hand = pressing();
    press(hand);
    const double last = hand.sample.time;
    const int felt = ticksOfForce(hand, [&](int i) { return stamp(i, last); });
    EXPECT_GE(felt, 49) << what;
    EXPECT_LE(felt, 51) << what;
    // A clock that runs again is followed, whatever it says.
    int silent = 0;
    for (int i = 1; i <= 60; ++i) {
      hand.sample.time = 3.0 + 1e-3 * i;
      hand.tick();
      silent += (hand.out.flags & haptics::kFlagStaleSample) != 0u ? 1 : 0;
    }
    EXPECT_LE(silent, 51) << what;
    EXPECT_EQ(hand.out.flags & haptics::kFlagStaleSample, 0u) << what;
  };
  expectStale("nan", [&](int, double) { return kNan; });
  expectStale("infinite", [&](int, double) { return kInfinity; });
  expectStale("minus infinity", [&](int, double) { return -kInfinity; });
  expectStale("constant", [](int, double last) { return last; });
  expectStale("backwards", [](int i, double last) { return last - 1e-3 * i; });
  expectStale("backwards for long", [](int i, double last) { return 10.0 * last - 1.0 * i; });
  expectStale("to and fro", [](int i, double last) { return last - (i % 2 == 0 ? 1e-3 : 0.0); });
  expectStale("nan and constant", [&](int i, double last) { return i % 2 == 0 ? kNan : last; });
}

TEST_P(SamplesAtScale, StampsThatGoOnAreFresh) {
  const auto expectFresh = [&](const char* what, const auto& stamp) {
    HandProbe hand = pressing();
    press(hand);
    const double last = hand.sample.time;
    EXPECT_EQ(ticksOfForce(hand, [&](int i) { return stamp(i, last); }), -1) << what;
  };
  expectFresh("every tick", [](int i, double last) { return last + 1e-3 * i; });
  expectFresh("every fortieth", [](int i, double last) { return last + 0.04 * (i / 40); });
  expectFresh("one is nan", [](int i, double last) {
    return i == 7 ? std::numeric_limits<double>::quiet_NaN() : last + 1e-3 * i;
  });
  expectFresh("none at all", [](int, double) { return 0.0; });
}

TEST_P(SamplesAtScale, AGlitchOfOneReadingIsRefused) {
  HandProbe hand = pressing();
  press(hand);
  hand.at(s() * glm::dvec3(0.3, -0.2, -0.4));
  EXPECT_EQ(hand.out.hands[0].toHand.force, glm::dvec3(0.0));
  EXPECT_TRUE(hand.out.flags & haptics::kFlagSampleJump);
  EXPECT_TRUE(hand.out.flags & haptics::kFlagInvalidSample);
  hand.sample.worldFromDevice.position = inside(0.003);
  expectRecovery(hand);
}

TEST_P(SamplesAtScale, AHandThatStaysWhereItJumpedToIsFollowedThere) {
  HandProbe hand = pressing();
  press(hand);
  const glm::dvec3 there = s() * glm::dvec3(0.0, 0.0, -0.3);  // beyond the box
  for (int i = 1; i <= haptics::SampleGuard::kJumpTicks; ++i) {
    EXPECT_TRUE(hand.at(there).flags & haptics::kFlagSampleJump) << i;
    EXPECT_EQ(hand.out.hands[0].toHand.force, glm::dvec3(0.0));
  }
  EXPECT_EQ(hand.at(there).flags & haptics::kFlagSampleJump, 0u);
  EXPECT_TRUE(hand.out.flags & haptics::kFlagProxyReset);
  EXPECT_EQ(hand.out.worldFromProxy.position, there);
  EXPECT_EQ(hand.out.hands[0].toHand.force, glm::dvec3(0.0));
}

TEST_P(SamplesAtScale, ReadingsThatJumpAboutNeverGiveForce) {
  HandProbe hand = pressing();
  press(hand);
  for (int i = 0; i < 50; ++i) {
    hand.at(s() * glm::dvec3(0.3 * (i % 2 == 0 ? 1 : -1), 0.0, -0.4));
    EXPECT_EQ(hand.out.hands[0].toHand.force, glm::dvec3(0.0));
  }
}

TEST_P(SamplesAtScale, AFastHandIsNoJump) {
  HandProbe hand = pressing();
  hand.at(s() * glm::dvec3(0.0, 0.0, 0.06));
  hand.to(inside(0.03), s() * 9e-3);  // 9 m/s
  EXPECT_NEAR(hand.out.hands[0].toHand.force.z, 30.0, 1e-4);
  EXPECT_EQ(hand.out.flags & haptics::kFlagInvalidSample, 0u);
}

INSTANTIATE_TEST_SUITE_P(Scales, SamplesAtScale, testing::Values(1e-3, 1.0, 20.0));

TEST(Fault, NamesWhatBrokeUntilItIsCleared) {
  SceneBuilder b;
  b.addPart(boxMesh({0.1, 0.1, 0.1}));
  HandProbe hand(b.scene);
  hand.at({0.0, 0.0, 0.06});
  EXPECT_FALSE(hand.state.fault().raised());
  hand.commands = {{haptics::PartCommand::Kind::own, 99, {}}};
  EXPECT_TRUE(hand.tick().flags & haptics::kFlagFault);
  EXPECT_STREQ(hand.state.fault().condition, "data_.world.has(command.part)");
  EXPECT_GT(hand.state.fault().line, 0);
  EXPECT_TRUE(hand.tick().flags & haptics::kFlagFault);
  hand.state.resetFault();
  EXPECT_EQ(hand.tick().flags & haptics::kFlagFault, 0u);
  EXPECT_FALSE(hand.state.fault().raised());
}

TEST(DeviceDefaults, TakeTheLimitsAndTheStiffestContactOfADevice) {
  haptics::DeviceLimits limits;
  limits.maxForce = 5.0;
  limits.damping = 0.25;
  haptics::TickParameters p;
  EXPECT_DOUBLE_EQ(haptics::fitToDevice(limits, 0.0, p), 750.0);  // 1.5 times 2 b / T
  EXPECT_DOUBLE_EQ(p.forceLimit, 5.0);
  EXPECT_DOUBLE_EQ(p.stiffness, 750.0);
  EXPECT_DOUBLE_EQ(p.graspStiffness, 500.0);
  EXPECT_DOUBLE_EQ(p.stiffnessLimit, 750.0);
  EXPECT_TRUE(p.passivity);
  haptics::TickParameters delayed;
  EXPECT_DOUBLE_EQ(haptics::fitToDevice(limits, 0.5e-3, delayed), 250.0) << "b / (T/2 + t_d), and no more";
  limits.damping = 2.0;  // stiff enough for anything: the default stays
  haptics::TickParameters stiff;
  haptics::fitToDevice(limits, 0.0, stiff);
  EXPECT_DOUBLE_EQ(stiff.stiffness, 800.0);
  haptics::TickParameters input;
  EXPECT_EQ(haptics::fitToDevice({}, 0.0, input), 0.0);
  EXPECT_FALSE(input.passivity);
  EXPECT_DOUBLE_EQ(input.stiffness, 800.0);
}

TEST(DeviceDefaults, HoldForMaterialsThatAreStifferThanTheDeviceCanRender) {
  SceneBuilder b;
  b.addPart(boxMesh({0.1, 0.1, 0.1}));
  b.scene.materials[0].stiffness = 5000.0;
  haptics::TickParameters p = springOnly();
  p.stiffnessLimit = 500.0;
  HandProbe hand(b.scene, p);
  hand.at({0.0, 0.0, 0.06});
  hand.to({0.0, 0.0, 0.048}, 1e-3);
  EXPECT_NEAR(hand.out.hands[0].toHand.force.z, 1.0, 1e-6);
}

}  // namespace
}  // namespace tandem::test
