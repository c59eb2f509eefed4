#include <gtest/gtest.h>

#include <cmath>

#include "haptics/body/virtual_coupling.h"
#include "tests/haptics/hand_probe.h"

namespace tandem::test {
namespace {

using haptics::PartCommand;
using haptics::TickParameters;

struct Held {
  explicit Held(double mass, TickParameters parameters = springOnly()) : hand(scene(mass), parameters) {
    hand.at({0.0, 0.0, 0.02});
    hand.at({0.0, 0.0, 0.0205});
    hand.command(PartCommand::Kind::own, 0);
    hand.command(PartCommand::Kind::grasp, 0);
    hand.at({0.0, 0.0, 0.0205});
  }
  static assets::Scene scene(double mass) {
    SceneBuilder b;
    b.addPart(boxMesh({0.05, 0.03, 0.04}), {}, mass);
    return b.scene;
  }
  HandProbe hand;
};

TEST(HeldPart, IsTakenWithoutForce) {
  Held held(0.5);
  EXPECT_EQ(held.hand.out.hands[0].held, 0);
  ASSERT_EQ(held.hand.out.ownedCount, 1);
  EXPECT_TRUE(held.hand.out.owned[0].held);
  EXPECT_TRUE(held.hand.out.flags & haptics::kFlagHeldWithoutContact);
  EXPECT_LT(glm::length(held.hand.out.hands[0].toHand.force), 1e-9);
}

TEST(HeldPart, FollowsTheHandAndSettlesWithoutError) {
  for (const double mass : {0.01, 0.5, 5.0}) {
    Held held(mass);
    held.hand.to({0.1, 0.02, 0.07}, 2e-4);
    held.hand.sample.twist = {};
    for (int i = 0; i < 40000; ++i) held.hand.tick();
    const glm::dvec3 moved = held.hand.out.owned[0].worldFromPart.position;
    EXPECT_LT(glm::length(moved - glm::dvec3(0.1, 0.02, 0.0495)), 1e-5) << mass;
  }
}

TEST(HeldPart, IsStableFromTenGramsToAHundredKilograms) {
  for (const double mass : {0.01, 0.1, 1.0, 10.0, 100.0}) {
    Held held(mass);
    double peak = 0.0;
    for (int i = 0; i < 20'000; ++i) {
      const double a = i < 3000 ? 0.02 * i : 60.0;
      held.hand.at({0.05 * std::sin(a), 0.02 * std::cos(a) - 0.02, 0.0205});
      held.hand.sample.worldFromDevice.orientation = fromRotationVector({0.0, 0.8 * std::sin(a), 0.0});
      if (i >= 19'000) peak = std::max(peak, glm::length(held.hand.out.owned[0].twist.linear));
      ASSERT_TRUE(std::isfinite(held.hand.out.hands[0].toHand.force.x)) << mass;
    }
    // 100 kg on 4 N·s/m takes 50 s to settle; the others have.
    EXPECT_LT(peak, mass > 5.0 ? 0.1 : 1e-3) << mass;
    EXPECT_EQ(held.hand.out.flags & haptics::kFlagFault, 0u);
  }
}

TEST(HeldPart, ExplicitIntegrationOfTheSameCouplingDiverges) {
  // The control for the test above: 10 g in a small box on the same rotational spring, integrated explicitly.
  const double inertia = 0.01 / 12.0 * (0.03 * 0.03 + 0.04 * 0.04), k = 4.0, b = 0.02, dt = 1e-3;
  double angle = 0.01, rate = 0.0;
  for (int i = 0; i < 200 && std::abs(angle) < 1e6; ++i) {
    rate += dt * (-k * angle - b * rate) / inertia;
    angle += dt * rate;
  }
  EXPECT_GE(std::abs(angle), 1e6);

  haptics::RigidBody body;
  body.mass = 0.01;
  body.inertia = glm::dmat3(inertia);
  const haptics::CouplingGains gains{800.0, 4.0, k, b};
  const Pose device{{0.0, 0.0, 0.0}, fromRotationVector({0.01, 0.0, 0.0})};
  for (int i = 0; i < 200; ++i) haptics::stepCoupledBody(body, {}, device, {}, gains, glm::dvec3(0.0), dt);
  EXPECT_LT(glm::length(rotationVector(body.worldFromBody.orientation) - glm::dvec3(0.01, 0.0, 0.0)), 1e-6);
}

TEST(HeldPart, PutsItsWeightOnTheHand) {
  TickParameters p = springOnly();
  p.gravity = {0.0, 0.0, -9.81};
  Held held(0.1, p);
  held.hand.sample.twist = {};
  for (int i = 0; i < 3000; ++i) held.hand.tick();
  EXPECT_NEAR(held.hand.out.hands[0].toHand.force.z, -0.981, 1e-6);
  EXPECT_NEAR(held.hand.out.owned[0].worldFromPart.position.z, -0.981 / 800.0, 1e-6);
}

TEST(HeldPart, StaysWhereItIsLeft) {
  TickParameters p = springOnly();
  p.gravity = {0.0, 0.0, -9.81};
  Held held(0.2, p);
  held.hand.to({0.1, 0.0, 0.0205}, 5e-4);  // 0.5 m/s
  const glm::dvec3 left = held.hand.out.owned[0].worldFromPart.position;
  held.hand.command(PartCommand::Kind::letGo, 0);
  held.hand.tick();
  EXPECT_EQ(held.hand.out.hands[0].held, kNoPart);
  EXPECT_FALSE(held.hand.out.owned[0].atRest);
  for (int i = 0; i < 400; ++i) held.hand.tick();
  EXPECT_TRUE(held.hand.out.owned[0].atRest);
  const glm::dvec3 rest = held.hand.out.owned[0].worldFromPart.position;
  EXPECT_LT(glm::length(rest - left), 0.5 * 0.03 * 1.1);
  for (int i = 0; i < 100; ++i) held.hand.tick();
  EXPECT_EQ(held.hand.out.owned[0].worldFromPart.position, rest);
}

TEST(HeldPart, ForceFadesWhenItIsLost) {
  for (const PartCommand::Kind kind : {PartCommand::Kind::letGo, PartCommand::Kind::disown}) {
    TickParameters p = springOnly();
    p.gravity = {0.0, 0.0, -9.81};
    Held held(0.2, p);
    held.hand.sample.twist = {};
    for (int i = 0; i < 2000; ++i) held.hand.tick();
    glm::dvec3 last = held.hand.out.hands[0].toHand.force;
    ASSERT_NEAR(last.z, -1.962, 1e-3);
    held.hand.command(kind, 0);
    for (int i = 0; i < 400; ++i) {
      held.hand.tick();
      // 0.3 s from full to nothing: 6.6 mN a tick, where a step would be 2 N.
      EXPECT_LE(glm::length(held.hand.out.hands[0].toHand.force - last), 1.962 / 300.0 + 1e-6) << i;
      last = held.hand.out.hands[0].toHand.force;
    }
    EXPECT_EQ(last, glm::dvec3(0.0));
  }
}

TEST(HeldPart, StylusLeavesAReleasedPartWithoutAForceStep) {
  TickParameters p = springOnly();
  p.damping = 1.0;
  HandProbe hand(Held::scene(0.5), p);
  hand.at({0.0, 0.0, 0.03});
  hand.to({0.0, 0.0, 0.018}, 2e-4);  // 2 mm deep
  glm::dvec3 last = hand.out.hands[0].toHand.force;
  ASSERT_NEAR(last.z, 1.6 + 0.2, 1e-5);
  hand.command(PartCommand::Kind::own, 0);
  hand.command(PartCommand::Kind::grasp, 0);
  double step = 0.0;
  const auto watch = [&] {
    step = std::max(step, glm::length(hand.out.hands[0].toHand.force - last));
    last = hand.out.hands[0].toHand.force;
  };
  hand.sample.twist = {};
  for (int i = 0; i < 1000; ++i, watch()) hand.tick();
  EXPECT_LT(glm::length(last), 1e-6);
  hand.command(PartCommand::Kind::letGo, 0);
  for (int i = 0; i < 500; ++i, watch()) hand.tick();
  EXPECT_EQ(hand.out.touched, 0);  // what the stylus is inside of can be taken again
  const glm::dvec3 part = hand.out.owned[0].worldFromPart.position;
  for (int i = 0; i < 100; ++i, watch()) hand.at(part + glm::dvec3(0.0, 0.0, 0.018 + 5e-5 * i));
  EXPECT_LT(step, 0.05);
  // Outside it is solid again.
  hand.to(part + glm::dvec3(0.0, 0.0, 0.018), 1e-4);
  EXPECT_GT(hand.out.hands[0].toHand.force.z, 1.0);
}

TEST(HeldPart, ToolDoesNotFeelWhatItHolds) {
  Held held(0.3);
  held.hand.to({0.0, 0.0, -0.05}, 1e-4);
  EXPECT_EQ(held.hand.out.contactCount, 0);
}

TEST(HeldPart, SaysSoWhenTooManyAreOwned) {
  SceneBuilder b;
  const std::uint32_t mesh = b.addMesh(boxMesh({0.01, 0.01, 0.01}));
  for (int i = 0; i < 10; ++i) b.addPart(mesh, {{0.1 * i, 0.0, 0.0}, {1.0, 0.0, 0.0, 0.0}}, 0.1);
  HandProbe hand(b.scene);
  for (PartId i = 0; i < 8; ++i) hand.command(PartCommand::Kind::own, i);
  EXPECT_EQ(hand.at({0.0, 0.0, 0.5}).flags & haptics::kFlagOverflow, 0u);
  EXPECT_EQ(hand.out.ownedCount, 8);
  hand.command(PartCommand::Kind::own, 8);
  EXPECT_TRUE(hand.at({0.0, 0.0, 0.5}).flags & haptics::kFlagOverflow);
  hand.command(PartCommand::Kind::disown, 3);
  hand.command(PartCommand::Kind::own, 9);
  EXPECT_EQ(hand.at({0.0, 0.0, 0.5}).flags & haptics::kFlagOverflow, 0u);
  EXPECT_EQ(hand.out.owned[7].part, 9);
}

TEST(HeldPart, SurvivesAReadingThatIsFiniteButAbsurd) {
  Held held(0.5);
  held.hand.at({1e308, 0.0, 0.0});
  EXPECT_TRUE(held.hand.out.flags & haptics::kFlagInvalidSample);
  held.hand.at({0.0, 0.0, 0.0205});
  for (int i = 0; i < 100; ++i) held.hand.tick();
  EXPECT_FALSE(held.hand.out.flags & haptics::kFlagFault);
  ASSERT_EQ(held.hand.out.ownedCount, 1);
  EXPECT_LT(glm::length(held.hand.out.owned[0].worldFromPart.position), 1e-3);
}

}  // namespace
}  // namespace tandem::test
