#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <string>

#include "haptics/tick_data.h"
#include "tests/haptics/hand_probe.h"
#include "tests/support/allocation_counter.h"

namespace tandem::test {
namespace {

using haptics::TickParameters;

assets::Scene boxScene() {
  SceneBuilder b;
  b.addPart(boxMesh({0.1, 0.1, 0.02}));
  return b.scene;
}

TEST(Tick, GivesZeroForceForAnInvalidSampleAndRecovers) {
  HandProbe hand(boxScene());
  hand.at({0.0, 0.0, 0.02});
  hand.to({0.0, 0.0, 0.008}, 1e-3);
  const glm::dvec3 before = hand.out.hands[0].toHand.force;
  ASSERT_GT(before.z, 1.0);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const haptics::DeviceSample good = hand.sample;
  haptics::DeviceSample bad[4] = {good, good, good, good};
  bad[0].valid = false;
  bad[1].worldFromDevice.position.y = nan;
  bad[2].worldFromDevice.orientation.w = nan;
  bad[3].twist.linear.x = std::numeric_limits<double>::infinity();
  for (const haptics::DeviceSample& sample : bad) {
    hand.sample = sample;
    hand.tick();
    EXPECT_EQ(hand.out.hands[0].toHand.force, glm::dvec3(0.0));
    EXPECT_TRUE(hand.out.flags & haptics::kFlagInvalidSample);
    hand.sample = good;
    hand.tick();
    EXPECT_EQ(hand.out.flags & haptics::kFlagInvalidSample, 0u);
    EXPECT_NEAR(hand.out.hands[0].toHand.force.z, before.z, 1e-6);
  }
}

TEST(Tick, PutsTheProxyOntoAHandThatWasLongUnseen) {
  HandProbe hand(boxScene());
  EXPECT_TRUE(hand.at({0.0, 0.0, 0.02}).flags & haptics::kFlagProxyReset);
  EXPECT_FALSE(hand.at({0.0, 0.0, 0.02}).flags & haptics::kFlagProxyReset);
  hand.sample.valid = false;
  for (int i = 0; i < 300; ++i) hand.tick();
  EXPECT_TRUE(hand.at({0.0, 0.0, -0.02}).flags & haptics::kFlagProxyReset);
  EXPECT_EQ(hand.out.worldFromProxy.position, glm::dvec3(0.0, 0.0, -0.02));
  EXPECT_EQ(hand.out.hands[0].toHand.force, glm::dvec3(0.0));
}

TEST(Tick, LimitsForceAndTheRateThatADeviceCanFollow) {
  TickParameters p = springOnly(5000.0);
  p.forceLimit = 3.3;
  p.deviceSlewLimit = 400.0;
  HandProbe hand(boxScene(), p);
  hand.at({0.0, 0.0, 0.011});
  glm::dvec3 last(0.0);
  std::uint32_t flags = 0;
  for (int i = 0; i < 100; ++i) {
    hand.at({0.0, 0.0, i < 50 ? 0.005 : 0.02});
    EXPECT_LE(glm::length(hand.out.hands[0].toHand.force), 3.3 + 1e-12);
    EXPECT_LE(glm::length(hand.out.hands[0].toHand.force - last), 0.4 + 1e-12);
    last = hand.out.hands[0].toHand.force;
    flags |= hand.out.flags;
    if (i == 49) {
      EXPECT_NEAR(last.z, 3.3, 1e-12);
    }
  }
  EXPECT_EQ(last, glm::dvec3(0.0));
  EXPECT_TRUE(flags & haptics::kFlagForceLimited);
  EXPECT_TRUE(flags & haptics::kFlagSlewLimited);
}

TEST(Tick, AppliesGainAndTheEmergencyKey) {
  HandProbe hand(boxScene());
  hand.parameters.gain = 0.25;
  hand.at({0.0, 0.0, 0.02});
  hand.at({0.0, 0.0, 0.008});
  EXPECT_NEAR(hand.out.hands[0].toHand.force.z, 0.25 * 800.0 * 0.002, 1e-6);
  hand.parameters.zeroForce = true;
  EXPECT_EQ(hand.tick().hands[0].toHand.force, glm::dvec3(0.0));
}

TickParameters rampedSpring() {
  TickParameters p = springOnly();
  p.slewLimit = 400.0;
  return p;
}

/// Presses on the box; then the proxy rests on a triangle that is not there.
void pressAndBreakTheProxy(HandProbe& hand) {
  hand.at({0.0, 0.0, 0.02});
  hand.to({0.0, 0.0, 0.008}, 1e-4);
  for (int i = 0; i < 20; ++i) hand.tick();
  hand.state.data().tool.proxy().planes[0].surface.triangle = 999;
}

TEST(Tick, LatchesABrokenInvariantOfTheProxyAndRampsTheForceToZero) {
  HandProbe hand(boxScene(), rampedSpring());
  pressAndBreakTheProxy(hand);
  double last = hand.out.hands[0].toHand.force.z;
  ASSERT_NEAR(last, 1.6, 1e-6);
  for (int i = 0; i < 3; ++i) {
    hand.tick();
    EXPECT_TRUE(hand.out.flags & haptics::kFlagFault);
    EXPECT_NEAR(hand.out.hands[0].toHand.force.z, last - 0.4, 1e-9);
    last = hand.out.hands[0].toHand.force.z;
  }
  for (int i = 0; i < 5; ++i) hand.tick();
  EXPECT_EQ(hand.out.hands[0].toHand.force, glm::dvec3(0.0));
  const haptics::FaultLatch& fault = hand.state.fault();
  EXPECT_NE(std::string(fault.condition).find("triangle <"), std::string::npos);
  EXPECT_NE(std::string(fault.file).find("contact_world.cpp"), std::string::npos);
}

TEST(Tick, FeelsAgainOnceABrokenInvariantHoldsAndItsFaultIsReset) {
  HandProbe hand(boxScene(), rampedSpring());
  pressAndBreakTheProxy(hand);
  for (int i = 0; i < 10; ++i) hand.tick();
  hand.state.data().tool.proxy().planes[0].surface.triangle = 0;
  hand.tick();
  EXPECT_EQ(hand.out.hands[0].toHand.force, glm::dvec3(0.0));
  hand.state.resetFault();
  for (int i = 0; i < 10; ++i) hand.tick();
  EXPECT_EQ(hand.out.flags & haptics::kFlagFault, 0u);
  EXPECT_NEAR(hand.out.hands[0].toHand.force.z, 1.6, 1e-6);
}

TEST(Tick, RunsTheCommandsBehindOneThatBreaksAnInvariant) {
  SceneBuilder b;
  b.addPart(boxMesh({0.1, 0.1, 0.02}));
  const PartId taken = b.addPart(boxMesh({0.01, 0.01, 0.01}), {{0.0, 0.0, 0.1}, {1.0, 0.0, 0.0, 0.0}}, 0.1);
  const PartId next = b.addPart(boxMesh({0.01, 0.01, 0.01}), {{0.05, 0.0, 0.1}, {1.0, 0.0, 0.0, 0.0}}, 0.1);
  b.scene.joints.emplace_back();
  b.scene.joints[0].partB = taken;  // with a joint it moves by contact, so it takes the tool along
  HandProbe hand(b.scene, rampedSpring());
  pressAndBreakTheProxy(hand);
  hand.state.data().tool.proxy().planes[0].surface.part = 99;
  using Kind = haptics::PartCommand::Kind;
  hand.command(Kind::own, taken);
  hand.command(Kind::grasp, taken);  // asks how stiff the contacts are that end, those of the broken proxy
  hand.command(Kind::own, next);
  hand.tick();
  EXPECT_NE(std::string(hand.state.fault().condition).find("has(part)"), std::string::npos);
  EXPECT_TRUE(hand.state.data().held.owns(taken));
  EXPECT_TRUE(hand.state.data().held.owns(next));
}

TEST(Tick, AbortsOnABrokenInvariantBetweenTicks) {
  HandProbe hand(boxScene());
  hand.tick();
  EXPECT_DEATH(hand.state.meshesChanged(99), "broken invariant: mesh < ");
}

TEST(Tick, LatchesAFaultAndLetsGoUntilItIsReset) {
  TickParameters p = springOnly();
  p.slewLimit = 400.0;
  HandProbe hand(boxScene(), p);
  hand.at({0.0, 0.0, 0.02});
  hand.at({0.0, 0.0, 0.008});
  for (int i = 0; i < 20; ++i) hand.tick();
  ASSERT_NEAR(hand.out.hands[0].toHand.force.z, 1.6, 1e-6);
  hand.commands = {{haptics::PartCommand::Kind::own, 99, {}}};  // no such part: a programmer's error
  hand.tick();
  EXPECT_NEAR(hand.out.hands[0].toHand.force.z, 1.2, 1e-6);  // a ramp, not a step
  for (int i = 0; i < 20; ++i) hand.tick();
  EXPECT_EQ(hand.out.hands[0].toHand.force, glm::dvec3(0.0));
  EXPECT_TRUE(hand.out.flags & haptics::kFlagFault);
  EXPECT_NE(hand.state.data().fault.condition, nullptr);
  hand.state.resetFault();
  for (int i = 0; i < 20; ++i) hand.tick();
  EXPECT_EQ(hand.out.flags & haptics::kFlagFault, 0u);
  EXPECT_NEAR(hand.out.hands[0].toHand.force.z, 1.6, 1e-6);
}

TEST(Tick, NeverAllocates) {
  SceneBuilder b;
  const PartId still = b.addPart(sphereMesh(0.02, 32));
  const PartId mover = b.addPart(boxMesh({0.01, 0.01, 0.01}), {{0.05, 0.0, 0.0}, {1.0, 0.0, 0.0, 0.0}}, 0.1);
  b.scene.materials[0].staticFriction = b.scene.materials[0].dynamicFriction = 0.3;
  HandProbe hand(b.scene);
  hand.moved.reserve(4);
  hand.commands.reserve(4);
  hand.at({0.03, 0.0, 0.0});
  std::uint64_t allocations = 0;
  bool touchedStill = false, held = false;
  for (int i = 0; i < 2000; ++i) {
    const double a = 0.004 * i;
    if (i == 500) hand.command(haptics::PartCommand::Kind::own, mover);
    if (i == 501) hand.command(haptics::PartCommand::Kind::grasp, mover);
    if (i == 1200) hand.command(haptics::PartCommand::Kind::letGo, mover);
    if (i == 1900) hand.command(haptics::PartCommand::Kind::disown, mover);
    if (i < 500) hand.moved.push_back({mover, {{0.05, 1e-5 * i, 0.0}, {1.0, 0.0, 0.0, 0.0}}, {}});
    const AllocationScope scope;
    hand.at(0.018 * glm::dvec3(std::cos(a), std::sin(a), 0.3 * std::sin(3.0 * a)));
    allocations += scope.count();
    touchedStill = touchedStill || (hand.out.contactCount > 0 && hand.out.contacts[0].part == still);
    held = held || hand.out.hands[0].held == mover;
  }
  EXPECT_EQ(allocations, 0u);
  EXPECT_TRUE(touchedStill);
  EXPECT_TRUE(held);
  const AllocationScope scope;            // the counter does count
  ::operator delete(::operator new(16));  // a new-expression could be optimised away
  EXPECT_GE(scope.count(), 1u);
}

TEST(Tick, SameInputsGiveTheSameBits) {
  SceneBuilder b;
  b.addPart(sphereMesh(0.02, 32));
  b.addPart(boxMesh({0.05, 0.05, 0.01}), {{0.0, 0.0, -0.022}, {1.0, 0.0, 0.0, 0.0}});
  HandProbe one(b.scene), two(b.scene);
  for (int i = 0; i < 500; ++i) {
    const double a = 0.01 * i;
    const glm::dvec3 p = 0.02 * glm::dvec3(std::cos(a), std::sin(a), std::sin(2.0 * a));
    one.at(p);
    two.at(p);
    ASSERT_EQ(std::memcmp(&one.out.hands[0].toHand, &two.out.hands[0].toHand, sizeof(Wrench)), 0) << i;
  }
}

TEST(Tick, NamesThePartWithinReachOfAGrasp) {
  SceneBuilder b;
  const PartId part = b.addPart(boxMesh({0.1, 0.1, 0.1}), {}, 1.0);  // diagonal 173 mm: reach 3.5 mm
  HandProbe hand(b.scene);
  EXPECT_EQ(hand.at({0.0, 0.0, 0.054}).touched, kNoPart);
  EXPECT_EQ(hand.at({0.0, 0.0, 0.053}).touched, part);
  EXPECT_EQ(hand.out.contactCount, 0);
}

TEST(Tick, PassesThroughPartsWhoseFilterShutsOutAll) {
  SceneBuilder b;
  b.addPart(boxMesh({0.1, 0.1, 0.02}));
  b.scene.parts[0].filter.collidesWith = 0;
  HandProbe hand(b.scene);
  hand.at({0.0, 0.0, 0.02});
  hand.to({0.0, 0.0, 0.0}, 1e-3);
  EXPECT_EQ(hand.out.hands[0].toHand.force, glm::dvec3(0.0));
}

TEST(Tick, DropsMotionsThatCannotBeUsed) {
  HandProbe hand(boxScene());
  hand.at({0.0, 0.0, 0.02});
  Pose broken;
  broken.position.x = std::numeric_limits<double>::quiet_NaN();
  hand.moved = {{0, broken, {}}, {77, {}, {}}};
  hand.at({0.0, 0.0, 0.008});
  EXPECT_TRUE(hand.out.flags & haptics::kFlagOverflow);
  EXPECT_FALSE(hand.out.flags & haptics::kFlagFault);
  EXPECT_NEAR(hand.out.hands[0].toHand.force.z, 1.6, 1e-6);
}

TEST(Tick, FeelsImplicitShapes) {
  assets::Scene scene;
  scene.materials.emplace_back();
  scene.materials[0].stiffness = 500.0;
  assets::Part part;
  assets::ImplicitShape sphere;
  sphere.kind = assets::ImplicitShape::Kind::sphere;
  sphere.radiusBottom = 0.02;
  part.shapes = {sphere};
  scene.parts = {part};
  HandProbe hand(scene);
  hand.at({0.0, 0.0, 0.03});
  hand.to({0.0, 0.0, 0.018}, 1e-3);
  EXPECT_NEAR(hand.out.hands[0].toHand.force.z, 500.0 * 0.002, 500.0 * 0.02 * 2e-4);
}

}  // namespace
}  // namespace tandem::test
