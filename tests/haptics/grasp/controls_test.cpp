#include "haptics/grasp/controls.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/haptics/grasp/control_scenes.h"
#include "tests/haptics/hand_probe.h"

namespace tandem::test {
namespace {

using assets::Control;
using assets::ControlKind;
using haptics::PartCommand;

constexpr double kContact = 2000.0;  // N/m

double valueOf(const HandProbe& hand, const Control& control) {
  return assets::controlValue(control, hand.state.worldFromPart(control.part));
}

/// What a button of buttonScene(s) resists with, written out: spring with preload, and the click's bump.
double forceOfButton(double q, double s) {
  const double x = (q / s - 1e-3) / 0.3e-3;
  const double bump = std::abs(x) < 1.0 ? 0.4 * (1.0 + std::cos(kPi * x)) : 0.0;
  return s * (300.0 * (q / s + 1e-3) + bump);
}

struct Press {
  std::vector<double> force;  // N on the hand, one a micrometre (times s)
  std::vector<double> value;  // m
};

/// Presses a point slowly onto the middle of the button, `steps` micrometres deep.
Press press(double s, int steps) {
  HandProbe hand(buttonScene(s).scene, springOnly(kContact));
  const Control control = hand.contact.scene().controls[0];
  hand.at({0.0, 0.0, 1e-3 * s});
  hand.command(PartCommand::Kind::own, 0);
  hand.to({0.0, 0.0, 0.0}, 1e-5 * s);
  Press out;
  for (int i = 1; i <= steps; ++i) {
    hand.at({0.0, 0.0, -1e-6 * s * i});
    out.force.push_back(hand.out.hands[0].toHand.force.z);
    out.value.push_back(valueOf(hand, control));
  }
  return out;
}

TEST(Controls, AButtonClicksAsItsProfileSays) {
  // In equilibrium the tool's spring carries what the button resists with: k (x - q) = R(q). Pressed slowly,
  // q follows the first solution above the last one; where the curve folds back, it snaps to the next.
  for (const double s : {1e-3, 1.0, 20.0}) {
    const Press pressed = press(s, 3500);
    double q = 0.0, peak = 0.0, trough = 1e300, worst = 0.0;
    int settled = 0, snaps = 0;
    for (int i = 1; i <= 3500; ++i) {
      const double x = 1e-6 * s * i;
      const double before = q;
      while (q < 2e-3 * s && q + forceOfButton(q, s) / kContact < x) q += 1e-8 * s;
      if (q - before > 50e-6 * s) {
        ++snaps;
        settled = i + 150;  // it rings down after the snap
      }
      if (i < settled) continue;
      const double expected = kContact * (x - q);
      worst = std::max(worst, std::abs(pressed.force[static_cast<std::size_t>(i - 1)] - expected) / s);
      if (i > 100) {
        (snaps == 0 ? peak : trough) = snaps == 0 ? std::max(peak, expected) : std::min(trough, expected);
      }
    }
    EXPECT_EQ(snaps, 1);
    EXPECT_LT(worst, 0.03) << s;  // N at scale 1: near the fold the cap moves fast, and its damper adds to it
    EXPECT_GT(peak - trough, 0.3 * s) << s;  // the click that is felt
    EXPECT_NEAR(pressed.value.back() / s, 2e-3, 1e-12);
  }
}

TEST(Controls, AButtonWithoutItsClickHasNoDrop) {
  // The control for the test above: the same button, and the force only grows.
  assets::Scene scene = buttonScene(1.0).scene;
  scene.controls[0].click.drop = 0.0;
  HandProbe hand(scene, springOnly(kContact));
  hand.at({0.0, 0.0, 1e-3});
  hand.command(PartCommand::Kind::own, 0);
  hand.to({0.0, 0.0, -5e-4}, 1e-6);
  double last = hand.out.hands[0].toHand.force.z, drop = 0.0;
  for (int i = 501; i <= 3500; ++i) {
    hand.at({0.0, 0.0, -1e-6 * i});
    drop = std::max(drop, last - hand.out.hands[0].toHand.force.z);
    last = hand.out.hands[0].toHand.force.z;
  }
  EXPECT_LT(drop, 1e-3);
}

TEST(Controls, AButtonComesBackWithTheTool) {
  HandProbe hand(buttonScene(1.0).scene, springOnly(kContact));
  hand.at({0.0, 0.0, 1e-3});
  hand.command(PartCommand::Kind::own, 0);
  hand.to({0.0, 0.0, -3e-3}, 2e-6);
  hand.to({0.0, 0.0, 1e-3}, 2e-6);
  for (int i = 0; i < 500; ++i) hand.tick();
  EXPECT_NEAR(valueOf(hand, hand.contact.scene().controls[0]), 0.0, 1e-15);
  EXPECT_TRUE(hand.out.owned[0].atRest);
}

TEST(Controls, PressingAndReleasingTakesWorkFromTheHand) {
  for (const double damping : {0.0, 2.0}) {
    assets::Scene scene = buttonScene(1.0).scene;
    scene.controls[0].damping = damping;
    HandProbe hand(scene, springOnly(kContact));
    hand.at({0.0, 0.0, 1e-4});
    hand.command(PartCommand::Kind::own, 0);
    double work = 0.0;  // done by the hand
    glm::dvec3 force(0.0);
    for (int i = 0; i < 10'000; ++i) {
      const glm::dvec3 to(0.0, 0.0, 1e-4 - 1.5e-3 * (1.0 - std::cos(2.0 * kPi * i / 1000.0)));
      const glm::dvec3 way = to - hand.sample.worldFromDevice.position;
      work -= glm::dot(0.5 * force, way);
      hand.at(to);
      force = hand.out.hands[0].toHand.force;
      work -= glm::dot(0.5 * force, way);
    }
    EXPECT_GT(work, -1e-6) << damping;
  }
}

TEST(Controls, AControlThatIsNotOwnedIsRigid) {
  HandProbe hand(buttonScene(1.0).scene, springOnly(kContact));
  hand.at({0.0, 0.0, 1e-3});
  hand.to({0.0, 0.0, -1e-3}, 1e-5);
  EXPECT_NEAR(hand.out.hands[0].toHand.force.z, kContact * 1e-3, 1e-5);
  EXPECT_NEAR(valueOf(hand, hand.contact.scene().controls[0]), 0.0, 1e-15);
}

TEST(Controls, ADialYieldsAtTheTorqueOfItsDetents) {
  for (const double s : {1e-3, 1.0, 20.0}) {
    HandProbe hand(dialScene(s).scene, springOnly(kContact));
    const Control control = hand.contact.scene().controls[0];
    const double r = 80e-3 * s;
    hand.at({r, -6e-3 * s, 0.0});
    hand.command(PartCommand::Kind::own, 0);
    double torque = 0.0, yielded = 0.0;
    for (int i = 0; i < 24'000 && yielded == 0.0; ++i) {
      hand.at({r, (-6e-3 + 2e-6 * i) * s, 0.0});
      const double value = valueOf(hand, control);
      if (hand.out.contactCount > 0) {
        const glm::dvec3 arm = hand.out.contacts[0].point;
        torque = std::max(torque, glm::cross(arm, -hand.out.hands[0].toHand.force).z);
      }
      if (value > kPi / 12.0) yielded = value;
    }
    EXPECT_GT(yielded, 0.0) << s;
    EXPECT_NEAR(torque / (0.02 * s * s), 1.0, 0.03) << s;
    // Left alone it goes into the next detent.
    for (int i = 0; i < 3000; ++i) hand.at({r, -20e-3 * s, 50e-3 * s});
    EXPECT_NEAR(valueOf(hand, control), kPi / 6.0, 2e-3) << s;
  }
}

TEST(Controls, ASliderStopsAtItsEndsAndIsHardThere) {
  for (const double s : {1e-3, 1.0, 20.0}) {
    SceneBuilder b;
    b.addPart(boxMesh(glm::dvec3(10e-3) * s), {}, 0.02);
    Control c = controlAlong(ControlKind::slider, {1.0, 0.0, 0.0}, glm::dvec3(0.0), {}, 0.0, 30e-3 * s);
    c.friction = 0.2 * s;
    c.damping = 1.0;
    b.scene.controls.push_back(c);
    HandProbe hand(b.scene, springOnly(kContact));
    hand.at(glm::dvec3(-6e-3, 0.0, 0.0) * s);
    hand.command(PartCommand::Kind::own, 0);
    hand.to(glm::dvec3(10e-3, 0.0, 0.0) * s, 1e-5 * s);
    EXPECT_NEAR(hand.out.hands[0].toHand.force.x / s, -(0.2 + 1.0 * 0.01), 0.02)
        << s;  // friction and damping at 10 mm/s
    hand.to(glm::dvec3(26e-3, 0.0, 0.0) * s, 1e-5 * s);
    EXPECT_NEAR(valueOf(hand, c) / s, 30e-3, 1e-12) << s;
    EXPECT_NEAR(hand.out.hands[0].toHand.force.x / s, -kContact * 1e-3, 0.01)
        << s;  // 1 mm into what now is a wall
  }
}

TEST(Controls, AGraspedDrawerMovesAlongItsAxisAndResistsAcrossIt) {
  SceneBuilder b;
  b.addPart(boxMesh({0.1, 0.05, 0.03}), {}, 0.5);
  Control c = controlAlong(ControlKind::drawer, {1.0, 0.0, 0.0}, glm::dvec3(0.0), {}, 0.0, 0.08);
  c.damping = 2.0;
  b.scene.controls.push_back(c);
  HandProbe hand(b.scene, springOnly(kContact));
  hand.at({0.06, 0.0, 0.0});
  hand.command(PartCommand::Kind::own, 0);
  hand.command(PartCommand::Kind::grasp, 0);
  hand.at({0.06, 0.0, 0.0});
  EXPECT_EQ(hand.out.hands[0].held, 0);
  hand.to({0.10, 0.002, -0.001}, 2e-5);
  hand.sample.twist = {};
  for (int i = 0; i < 3000; ++i) hand.tick();
  EXPECT_NEAR(valueOf(hand, c), 0.04, 1e-6);
  const double k = hand.parameters.graspStiffness;
  EXPECT_LT(glm::length(hand.out.hands[0].toHand.force - glm::dvec3(0.0, -0.002 * k, 0.001 * k)), 1e-3);
  hand.to({0.15, 0.0, 0.0}, 2e-5);
  hand.sample.twist = {};
  for (int i = 0; i < 3000; ++i) hand.tick();
  EXPECT_EQ(valueOf(hand, c), 0.08);  // its stop
  EXPECT_NEAR(hand.out.hands[0].toHand.force.x, -k * 0.01, 1e-3);
}

TEST(Controls, AGraspedDialTurnsWithTheTwistOfTheHand) {
  HandProbe hand(dialScene(1.0).scene, springOnly(kContact));
  const Control control = hand.contact.scene().controls[0];
  hand.at({0.0, 0.0, 0.01});
  hand.command(PartCommand::Kind::own, 0);
  hand.command(PartCommand::Kind::grasp, 0);
  for (int i = 0; i <= 4000; ++i) {
    hand.sample.worldFromDevice.orientation = fromRotationVector({0.0, 0.0, kPi / 3.0 * i / 4000.0});
    hand.tick();
  }
  for (int i = 0; i < 2000; ++i) hand.tick();
  EXPECT_NEAR(valueOf(hand, control), kPi / 3.0, 1e-4);
  // Half way to the next detent's edge: the detent's torque is what the hand feels.
  for (int i = 0; i <= 2000; ++i) {
    hand.sample.worldFromDevice.orientation = fromRotationVector({0.0, 0.0, kPi / 3.0 + 0.1 * i / 2000.0});
    hand.tick();
  }
  for (int i = 0; i < 2000; ++i) hand.tick();
  const double off = valueOf(hand, control) - kPi / 3.0;
  EXPECT_NEAR(hand.out.hands[0].toHand.torque.z, -0.02 * std::sin(12.0 * off), 1e-6);
  EXPECT_GT(off, 0.05);
}

TEST(Controls, ALayerShowsAndHidesWhatItNames) {
  SceneBuilder b;
  b.addPart(boxMesh(glm::dvec3(0.01)), {glm::dvec3(0.5, 0.0, 0.0), glm::dquat(1.0, 0.0, 0.0, 0.0)}, 0.02);
  const PartId shown = b.addPart(boxMesh({0.1, 0.1, 0.02}));
  Control c = controlAlong(ControlKind::layer, {1.0, 0.0, 0.0}, glm::dvec3(0.5, 0.0, 0.0),
                           b.scene.parts[0].worldFromPart, 0.0, 0.02);
  c.shows = {shown};
  c.threshold = 0.01;
  b.scene.controls.push_back(c);
  HandProbe hand(b.scene, springOnly(kContact));
  hand.at({0.0, 0.0, 0.015});
  hand.to({0.0, 0.0, 0.009}, 1e-4);
  EXPECT_EQ(hand.out.contactCount, 0);  // off: the hand goes through
  EXPECT_NE(hand.out.touched, shown);
  hand.to({0.0, 0.0, 0.015}, 1e-4);
  hand.commands.push_back({PartCommand::Kind::setPose, 0, assets::poseAt(c, 0.02)});
  hand.tick();
  hand.to({0.0, 0.0, 0.009}, 1e-4);
  EXPECT_EQ(hand.out.contactCount, 1);
  EXPECT_NEAR(hand.out.hands[0].toHand.force.z, kContact * 1e-3, 1e-3);
  // Off again: what was felt fades away, and nothing is left.
  hand.commands.push_back({PartCommand::Kind::setPose, 0, assets::poseAt(c, 0.0)});
  hand.sample.twist = {};
  hand.tick();
  EXPECT_EQ(hand.out.contactCount, 0);
  EXPECT_NEAR(hand.out.hands[0].toHand.force.z, kContact * 1e-3, 0.02);
  for (int i = 0; i < 400; ++i) hand.tick();
  EXPECT_EQ(hand.out.hands[0].toHand.force.z, 0.0);
}

TEST(Controls, APartThatAppearsAroundTheToolIsNotFeltUntilItIsLeft) {
  SceneBuilder b;
  b.addPart(boxMesh(glm::dvec3(0.01)), {glm::dvec3(0.5, 0.0, 0.0), glm::dquat(1.0, 0.0, 0.0, 0.0)}, 0.02);
  b.addPart(boxMesh({0.1, 0.1, 0.02}));
  Control c = controlAlong(ControlKind::layer, {1.0, 0.0, 0.0}, glm::dvec3(0.5, 0.0, 0.0),
                           b.scene.parts[0].worldFromPart, 0.0, 0.02);
  c.shows = {1};
  c.threshold = 0.01;
  b.scene.controls.push_back(c);
  HandProbe hand(b.scene, springOnly(kContact));
  hand.at({0.0, 0.0, 0.002});
  hand.commands.push_back({PartCommand::Kind::setPose, 0, assets::poseAt(c, 0.02)});
  for (int i = 0; i < 10; ++i) EXPECT_EQ(glm::length(hand.at({0.0, 0.0, 0.002}).hands[0].toHand.force), 0.0);
  hand.to({0.0, 0.0, 0.02}, 1e-4);
  hand.to({0.0, 0.0, 0.009}, 1e-4);
  EXPECT_GT(hand.out.hands[0].toHand.force.z, 1.0);
}

}  // namespace
}  // namespace tandem::test
