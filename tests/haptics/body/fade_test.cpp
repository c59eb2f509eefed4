// Forces that have ended fade over time, and give the hand no more than their spring held.

#include "haptics/body/fade.h"

#include <gtest/gtest.h>

#include <cmath>

#include <glm/geometric.hpp>

#include "haptics/tick_data.h"
#include "tests/haptics/hand_probe.h"

namespace tandem::test {
namespace {

using haptics::Fade;

constexpr double kTick = 1e-3, kTime = 0.3, kStiffness = 800.0;  // s, N/m
const glm::dvec3 kForce{0.3, -0.4, 1.2};                         // N
const double kStored = 0.5 * glm::dot(kForce, kForce) / kStiffness;

/// What a fade gives a hand that goes at this velocity, m/s, until nothing is left, J.
double givenTo(const glm::dvec3& velocity, double stiffness) {
  Fade fade;
  fade.start({kForce, {}}, {stiffness, 0.0}, kTime);
  double given = 0.0;
  while (fade.active()) {
    fade.advance(velocity * kTick, {}, kTick);
    given += glm::dot(fade.now().force, velocity * kTick);
  }
  return given;
}

TEST(Fade, IsAStraightLineToAHandThatStandsStill) {
  Fade fade;
  fade.start({kForce, 0.1 * kForce}, {kStiffness, 4.0}, kTime);
  for (int i = 1; i <= 300; ++i) {
    fade.advance({}, {}, kTick);
    EXPECT_LE(glm::length(fade.now().force - kForce * (1.0 - i / 300.0)), 1e-12);
    EXPECT_LE(glm::length(fade.now().torque - 0.1 * kForce * (1.0 - i / 300.0)), 1e-12);
  }
  EXPECT_FALSE(fade.active());
}

TEST(Fade, GivesAHandThatFollowsItNoMoreThanItsSpringHeld) {
  for (const double speed : {0.02, 0.05, 0.2, 1.0}) {
    const glm::dvec3 along = speed * glm::normalize(kForce);
    EXPECT_LE(givenTo(along, kStiffness), kStored * (1.0 + 1e-9)) << speed;
    // The negative control is the straight line alone: a spring as soft as to hold energy without end.
    EXPECT_GT(givenTo(along, 1e-9), 2.0 * kStored) << speed;
  }
}

TEST(Fade, LosesItsForceOverTheWayOfItsSpring) {
  Fade fade;
  const glm::dvec3 direction = glm::normalize(kForce);
  const double depth = glm::length(kForce) / kStiffness, step = depth / 1000.0;
  fade.start({kForce, {}}, {kStiffness, 0.0}, 1e6);
  for (int i = 1; i <= 900; ++i) {
    fade.advance(direction * step, {}, kTick);
    EXPECT_NEAR(glm::length(fade.now().force), kStiffness * (depth - i * step), 1e-2) << i;
  }
  // Back again it is as strong as before, and no stronger.
  for (int i = 0; i < 2000; ++i) fade.advance(-direction * step, {}, kTick);
  EXPECT_LE(glm::length(fade.now().force), glm::length(kForce) * (1.0 + 1e-12));
}

TEST(Fade, TakesEnergyFromAHandThatGoesAgainstIt) {
  EXPECT_LT(givenTo(-0.05 * glm::normalize(kForce), kStiffness), -0.5 * kStored);
}

TEST(Fade, OfTwoForcesTheEnergiesAdd) {
  Fade fade;
  fade.start({kForce, {}}, {kStiffness, 0.0}, kTime);
  fade.start({kForce, {}}, {kStiffness, 0.0}, kTime);
  double given = 0.0;
  const glm::dvec3 way = 2e-5 * glm::normalize(kForce);
  while (fade.active()) {
    fade.advance(way, {}, kTick);
    given += glm::dot(fade.now().force, way);
  }
  EXPECT_LE(given, 2.0 * kStored * (1.0 + 1e-9));
  EXPECT_GT(given, kStored);
}

/// A hand presses a part 1 mm deep, takes it and withdraws: what it is given, J. The coupling is left out.
double givenByAGrasp(double speed, bool byTimeAlone) {
  SceneBuilder b;
  b.addPart(boxMesh({0.1, 0.1, 0.1}), {}, 1.0);
  haptics::TickParameters p = springOnly(kStiffness);
  p.graspStiffness = p.graspDamping = p.graspRotStiffness = p.graspRotDamping = 0.0;
  HandProbe hand(b.scene, p);
  hand.at({0.0, 0.0, 0.051});
  hand.to({0.0, 0.0, 0.049}, 1e-4);
  hand.command(haptics::PartCommand::Kind::own, 0);
  hand.command(haptics::PartCommand::Kind::grasp, 0);
  hand.at({0.0, 0.0, 0.049});
  EXPECT_EQ(hand.out.hands[0].held, 0);
  EXPECT_NEAR(hand.out.hands[0].toHand.force.z, 1e-3 * kStiffness, 0.01);
  if (byTimeAlone) {
    hand.state.data().hands[0].fade() = Fade{};
    hand.state.data().hands[0].fade().start({hand.out.hands[0].toHand.force, {}}, {1e-9, 0.0}, p.fadeTime);
  }
  double given = 0.0;
  for (int i = 1; i <= 400; ++i) {
    const double force = hand.out.hands[0].toHand.force.z, way = speed * kTick;
    hand.at({0.0, 0.0, 0.049 + way * i});
    given += force * way;
  }
  EXPECT_EQ(hand.out.hands[0].toHand.force.z, 0.0);
  return given;
}

TEST(Fade, AGraspGivesNoMoreThanTheContactHeld) {
  const double stored = 0.5 * kStiffness * 1e-6;
  for (const double speed : {0.005, 0.02, 0.1}) {
    const double held = 0.5 * kStiffness * speed * kTick * speed * kTick;  // what holding over a tick gives
    EXPECT_LE(givenByAGrasp(speed, false), stored * 1.0001 + held) << speed;
    EXPECT_GT(givenByAGrasp(speed, true), 1.4 * stored) << speed;
  }
}

}  // namespace
}  // namespace tandem::test
