// A held part on a device of six axes, closed through the tick: pressed into a corner, in a bore, on an edge
// far from the grip, free. How stiff may the coupling be? Pushed by a steady wrench, so that nothing but the
// device takes energy. What is summed up is all that coupling and device have given out at the hand's port,
// so that the energy that the hand put in stays in.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>

#include <glm/geometric.hpp>

#include "haptics/body/virtual_coupling.h"
#include "haptics/safety/device_defaults.h"
#include "haptics/tick_data.h"
#include "tests/haptics/contact/part_contact_case.h"
#include "tests/haptics/grasp/closed_loop_case.h"
#include "tests/support/six_axis_device.h"

namespace tandem::test {
namespace {

constexpr int kMaxDelay = 8;  // ticks

/// A part, where it is taken and how the hand pushes.
struct Hold {
  Hold(const char* label, assets::Scene given, const glm::dvec3& grip)
      : name(label), scene(std::make_unique<assets::Scene>(std::move(given))), contact(*scene, 1) {
    contact.modelParts();
    worldFromGrip = scene->parts[0].worldFromPart * Pose{grip, {1.0, 0.0, 0.0, 0.0}};
  }

  const char* name;
  std::unique_ptr<assets::Scene> scene;
  haptics::ContactScene contact;
  Pose worldFromGrip;
  Wrench push{};  // from the first tick on
  Twist start{};  // of the device
};

// The hand's own spring, too soft to matter and without damping: it only keeps the device about where it
// started.

Wrench handOf(const Hold& hold, const Pose& device) {
  const glm::dvec3 turn = rotationVector(device.orientation * glm::conjugate(hold.worldFromGrip.orientation));
  return {hold.push.force - kHandStiffness * (device.position - hold.worldFromGrip.position),
          hold.push.torque - kHandRotStiffness * turn};
}

CasePart cube() { return {"cube", meshOf(boxSoup(glm::dvec3(0.02), 2)), {}, true}; }

/// A cube of 20 mm pushed into the corner of three blocks.
Hold corner() {
  Hold hold(
      "corner",
      sceneOfParts({cube(), block({0.0, 0.0, -0.04}), block({-0.04, 0.0, 0.0}), block({0.0, -0.04, 0.0})}),
      {0.004, 0.003, 0.005});
  hold.push.force = {-1.0, -1.0, -1.0};
  return hold;
}

/// A peg of 20 mm in its bore with 50 um around it, turned and pushed aside, gripped at its upper end.
Hold bore() {
  const Facets facets{24, 1};
  const CasePart peg{
      "peg", meshOf(pegSoup({0.01, 0.04, 0.001, facets})), {{0.0, 0.0, -0.02}, {1.0, 0.0, 0.0, 0.0}}, true};
  const CasePart hole{"block",
                      meshOf(boredBlockSoup({0.01005, 0.045, 0.03, 0.045, 0.0, Fit::around, facets}))};
  Hold hold("bore", sceneOfParts({peg, hole}), {0.0, 0.0, 0.04});
  hold.push = {{0.7, 0.4, 0.0}, {0.05, -0.08, 0.0}};
  return hold;
}

/// A bar of 80 mm gripped at one end, pressed down on the edge of a block under its other end.
constexpr double kLever = 0.06;  // m, from the grip to the edge
Hold lever() {
  const CasePart bar{"bar", meshOf(boxSoup({0.08, 0.01, 0.01}, 3)), {}, true};
  Hold hold("lever", sceneOfParts({bar, block({0.04 - kLever - 0.03, 0.0, -0.035})}), {0.04, 0.0, 0.0});
  hold.push.force = {0.0, 0.0, -1.0};
  return hold;
}

/// The cube with nothing about.
Hold nothing() {
  Hold hold("free", sceneOfParts({cube(), block({9.0, 0.0, 0.0})}), {0.0, 0.0, 0.04});
  hold.start = {{0.1, -0.05, 0.1}, {2.0, -1.0, 3.0}};
  return hold;
}

struct Loop {
  SixAxisParameters device;
  double share = 0.9, rotShare = 0.9;      // of the predicted limits
  double damping = 0.0, rotDamping = 0.0;  // of the coupling
  int delay = 0;                           // ticks
  bool defaults = false;                   // as fitToDevice() has them, in place of the above
  bool torque = true;                      // the device drives it
  bool turns = true;                       // and can be turned
  double seconds = 2.0;
};

struct Outcome {
  double early = 0.0, late = 0.0;          // m, peak to peak of the device, in the second and the last eighth
  double earlyTurn = 0.0, lateTurn = 0.0;  // rad
  double created = 0.0;  // J, the most that coupling and device gave out beyond what came in
  bool touched = true;   // in the last tick
};

haptics::TickParameters parametersOf(const Loop& loop) {
  const haptics::CouplingGains most =
      haptics::stiffestGrasp(loop.device.limits(), kPeriod, loop.delay * kPeriod);
  haptics::TickParameters p = rigParameters();
  p.slewLimit = p.torqueSlewLimit = 1e9;
  if (loop.defaults) {
    p = haptics::TickParameters{};
    haptics::fitToDevice(loop.device.limits(), loop.delay * kPeriod, p);
    return p;
  }
  p.graspStiffness = loop.share * most.stiffness;
  p.graspRotStiffness = loop.rotShare * most.rotStiffness;
  p.graspDamping = loop.damping;
  p.graspRotDamping = loop.rotDamping;
  return p;
}

Outcome run(const Hold& hold, const Loop& loop) {
  using Kind = haptics::PartCommand::Kind;
  haptics::TickState state(hold.contact);
  const haptics::TickParameters parameters = parametersOf(loop);
  SixAxisDevice device(loop.device, hold.worldFromGrip);
  device.setTwist(hold.start);
  std::array<Wrench, kMaxDelay> sent{};
  const int ticks = static_cast<int>(loop.seconds / kPeriod), eighth = ticks / 8;
  Extent place[2], turn[2];
  Outcome outcome;
  for (int i = 0; i < ticks; ++i) {
    haptics::TickInput input;
    input.hands[0].device = device.sample(kPeriod * i, kPeriod);
    const haptics::PartCommand take[2] = {{Kind::own, 0, hold.scene->parts[0].worldFromPart},
                                          {Kind::grasp, 0, {}}};
    if (i == 0) input.commands = take;
    const haptics::TickOutput out = haptics::tick(input, hold.contact, parameters, state);
    sent[static_cast<std::size_t>(i % kMaxDelay)] = out.hands[0].toHand;
    const Wrench command =
        i < loop.delay ? Wrench{} : sent[static_cast<std::size_t>((i - loop.delay) % kMaxDelay)];
    Wrench push = handOf(hold, device.pose());
    if (!loop.turns) push.torque = glm::dvec3(0.0);
    // A torque that is not shown moves nothing; the account has it all the same.
    if (!loop.torque) push.torque -= command.torque;
    device.step(command, push, kPeriod);
    outcome.touched = out.contactCount > 0;
    const Pose& pose = device.pose();
    if (!(glm::length(pose.position) < 10.0)) return {0.0, 1e9, 0.0, 1e9, device.mostGiven(), false};
    const int window = i / eighth == 1 ? 0 : i >= ticks - eighth ? 1 : -1;
    if (window < 0) continue;
    place[window].note(pose.position);
    turn[window].note(rotationVector(pose.orientation * glm::conjugate(hold.worldFromGrip.orientation)));
  }
  outcome.early = place[0].size(), outcome.late = place[1].size();
  outcome.earlyTurn = turn[0].size(), outcome.lateTurn = turn[1].size();
  outcome.created = device.mostGiven();
  return outcome;
}

// Of work summed over 40,000 steps of some 1e-5 J, J.

void print(const Hold& hold, const Loop& loop, const Outcome& o) {
  if (!atFullSize()) return;
  std::printf(
      "%-7s delay %d ms, B %.2g, quantum %.3g mm, %4.2f of the limits: way %8.3g -> %8.3g mm, turn %8.3g -> "
      "%8.3g mrad, created %8.3g J\n",
      hold.name, loop.delay, loop.damping, 1e3 * loop.device.quantum, loop.share, 1e3 * o.early, 1e3 * o.late,
      1e3 * o.earlyTurn, 1e3 * o.lateTurn, o.created);
}

/// The swing dies away, down to a few quanta, and nothing is given out that did not come in.
void expectRests(const Hold& hold, const Loop& loop) {
  const Outcome o = run(hold, loop);
  print(hold, loop, o);
  const SixAxisParameters& d = loop.device;
  EXPECT_LT(o.late, std::max(0.6 * o.early, 4.0 * d.quantum + 1e-6)) << hold.name << ' ' << loop.delay;
  EXPECT_LT(o.lateTurn, std::max(0.6 * o.earlyTurn, 4.0 * d.rotQuantum + 1e-4))
      << hold.name << ' ' << loop.delay;
  EXPECT_LE(o.created, kRounding) << hold.name << ' ' << loop.delay;
}

/// From two periods of delay on the coupling has some damping of its own, see stiffestGrasp().
Loop loopAt(double share, int delay) {
  Loop loop;
  loop.share = loop.rotShare = share;
  loop.delay = delay;
  if (delay > 1) loop.damping = 0.5 * loop.device.damping, loop.rotDamping = 0.5 * loop.device.rotDamping;
  return loop;
}

void expectRestsUpToTheLimits(const Hold& hold) {
  for (const int delay : {0, 1, 5}) {
    if (atFullSize()) {
      for (const double share : {0.5, 0.7, 0.8}) expectRests(hold, loopAt(share, delay));
    }
    expectRests(hold, loopAt(0.9, delay));
  }
  Loop read = loopAt(0.9, 0);
  read.device.quantum = 0.055e-3, read.device.rotQuantum = 1e-3;
  expectRests(hold, read);
}

TEST(GraspClosedLoop, APartInACornerRestsUpToNineTenthsOfTheLimits) { expectRestsUpToTheLimits(corner()); }
TEST(GraspClosedLoop, APartInABoreRestsUpToNineTenthsOfTheLimits) { expectRestsUpToTheLimits(bore()); }
TEST(GraspClosedLoop, APartOnALeverRestsUpToNineTenthsOfTheLimits) { expectRestsUpToTheLimits(lever()); }
TEST(GraspClosedLoop, AFreePartRestsUpToNineTenthsOfTheLimits) { expectRestsUpToTheLimits(nothing()); }

TEST(GraspClosedLoop, WithoutTorqueAPartRestsUpToNineTenthsOfTheLimit) {
  // A hand turns the device, or nothing does: what it then feels of turning comes through the lever. Turning
  // winds a spring that it does not feel, so the forces alone may give out what the torque would have taken,
  // and no more.
  for (Hold (*const make)() : {corner, lever}) {
    Hold hold = make();
    hold.push.torque = {0.01, -0.02, 0.01};
    for (const bool turns : {true, false}) {
      Loop loop = loopAt(0.9, 0);
      loop.torque = false;
      loop.turns = turns;
      expectRests(hold, loop);
    }
  }
}

TEST(GraspClosedLoop, TheDefaultsOfADeviceComeToRest) {
  // With the coupling's own damping, which the limits do not count on, quantised readings and the passivity
  // control.
  for (Hold (*const make)() : {corner, bore}) {
    const Hold hold = make();
    for (const int delay : {0, 5}) {
      Loop loop = loopAt(0.9, delay);
      loop.device.quantum = 0.03e-3, loop.device.rotQuantum = 0.2e-3;
      loop.defaults = true;
      const Outcome o = run(hold, loop);
      print(hold, loop, o);
      EXPECT_LT(o.late, 4.0 * loop.device.quantum) << hold.name << delay;
      EXPECT_LT(o.lateTurn, 4.0 * loop.device.rotQuantum) << hold.name << delay;
    }
  }
}

// The controls of the tests above. Who holds the part fast decides where it begins.

TEST(GraspClosedLoop, AboveTheLimitsAPartInACornerSwingsAndMakesEnergy) {
  const Hold hold = corner();
  for (const int delay : {0, 1, 5}) {
    // Nothing of the coupling's own damping here, which would move the limit up.
    Loop loop = loopAt(1.1, delay);
    loop.damping = loop.rotDamping = 0.0;
    const Outcome o = run(hold, loop);
    print(hold, loop, o);
    EXPECT_GT(o.created, 1e-5) << delay;
    EXPECT_GT(o.late, 0.9 * o.early) << delay;
    EXPECT_GT(o.late, 1e-3) << delay;
  }
}

TEST(GraspClosedLoop, AboveTheLimitOfTurningAPartInABoreSwingsOn) {
  // What the walls take when the peg strikes them keeps the account below zero, but it never comes to rest.
  const Hold hold = bore();
  Loop loop = loopAt(0.9, 0);
  loop.rotShare = 1.5;
  const Outcome o = run(hold, loop);
  print(hold, loop, o);
  EXPECT_GT(o.lateTurn, 0.8 * o.earlyTurn);
  EXPECT_GT(o.lateTurn, 0.01);
}

TEST(GraspClosedLoop, WithDelayAnUndampedCouplingSwingsAgainstAFreePart) {
  Loop loop = loopAt(0.9, 5);
  loop.damping = loop.rotDamping = 0.0;
  const Hold hold = nothing();
  const Outcome o = run(hold, loop);
  print(hold, loop, o);
  EXPECT_GT(o.created, 1e-3);
  EXPECT_GT(o.late, o.early);
}

TEST(GraspClosedLoop, ALeverPutsTheTurningSpringInSeries) {
  const Hold hold = lever();
  haptics::TickState state(hold.contact);
  haptics::TickParameters p = rigParameters();
  using Kind = haptics::PartCommand::Kind;
  const double down = 0.5e-3;
  haptics::TickOutput out;
  for (int i = 0; i < 400; ++i) {
    haptics::TickInput input;
    input.hands[0].device.worldFromDevice = hold.worldFromGrip;
    input.hands[0].device.worldFromDevice.position.z -= down * std::min(1.0, i / 100.0);
    input.hands[0].device.time = kPeriod * i;
    input.hands[0].device.valid = true;
    const haptics::PartCommand take[2] = {{Kind::own, 0, hold.scene->parts[0].worldFromPart},
                                          {Kind::grasp, 0, {}}};
    if (i == 0) input.commands = take;
    out = haptics::tick(input, hold.contact, p, state);
  }
  const double felt = 1.0 / (1.0 / p.graspStiffness + kLever * kLever / p.graspRotStiffness);
  EXPECT_NEAR(out.hands[0].toHand.force.z, felt * down, 0.01 * felt * down);
  EXPECT_LT(felt, 0.6 * p.graspStiffness);
  // A device that is not turned, as a mouse is not: contact turns the part against the spring, and lets it
  // turn back.
  const glm::dvec3 turn = rotationVector(state.worldFromPart(0).orientation);
  EXPECT_NEAR(turn.y, felt * down * kLever / p.graspRotStiffness, 0.02 * turn.y);
  for (int i = 400; i < 800; ++i) {
    haptics::TickInput input;
    input.hands[0].device.worldFromDevice = hold.worldFromGrip;
    input.hands[0].device.worldFromDevice.position.z += 0.02 * std::min(1.0, (i - 400) / 200.0);
    input.hands[0].device.time = kPeriod * i;
    input.hands[0].device.valid = true;
    out = haptics::tick(input, hold.contact, p, state);
  }
  EXPECT_LT(glm::length(rotationVector(state.worldFromPart(0).orientation)), 1e-4);
  EXPECT_EQ(out.contactCount, 0);
}

TEST(GraspTorque, ReachesTheDeviceWithinItsLimit) {
  const Hold hold = corner();
  haptics::TickState state(hold.contact);
  haptics::TickParameters p = rigParameters();
  p.torqueLimit = 0.1;
  using Kind = haptics::PartCommand::Kind;
  const glm::dvec3 axis{0.0, 0.0, 1.0};
  double before = 0.0;
  for (int i = 0; i < 300; ++i) {
    const double angle = 0.05 * std::min(1.0, i / 200.0);  // the wall behind the cube keeps it from turning
    haptics::TickInput input;
    input.hands[0].device.worldFromDevice = hold.worldFromGrip;
    input.hands[0].device.worldFromDevice.position -= glm::dvec3(1e-3, 1e-3, 1e-3) * std::min(1.0, i / 100.0);
    input.hands[0].device.worldFromDevice.orientation = fromRotationVector(angle * axis);
    input.hands[0].device.time = kPeriod * i;
    input.hands[0].device.valid = true;
    const haptics::PartCommand take[2] = {{Kind::own, 0, hold.scene->parts[0].worldFromPart},
                                          {Kind::grasp, 0, {}}};
    if (i == 0) input.commands = take;
    haptics::TickOutput out = haptics::tick(input, hold.contact, p, state);
    input.commands = {};
    while (state.data().partContact->isTaking(0)) out = haptics::tick(input, hold.contact, p, state);
    const double torque = glm::length(out.hands[0].toHand.torque);
    ASSERT_LE(torque, 0.1 + 1e-12);
    // It comes as the hand turns, not in steps.
    ASSERT_LT(std::abs(torque - before), 0.01) << i;
    before = torque;
    if (i == 299) {
      const glm::dvec3 part = rotationVector(state.worldFromPart(0).orientation);
      const glm::dvec3 wanted = p.graspRotStiffness * (part - angle * axis);
      EXPECT_GT(glm::length(wanted), 0.02);
      const double share = std::min(1.0, 0.1 / glm::length(wanted));
      EXPECT_LT(glm::length(out.hands[0].toHand.torque - share * wanted), 1e-3);
    }
  }
}

TEST(StiffestGrasp, FollowsTheDevicesDampingMassAndRate) {
  haptics::DeviceLimits device = SixAxisParameters{}.limits();
  haptics::CouplingGains most = haptics::stiffestGrasp(device, kPeriod, 0.0);
  EXPECT_DOUBLE_EQ(most.stiffness, 2000.0);
  EXPECT_DOUBLE_EQ(most.rotStiffness, 4.0);
  EXPECT_DOUBLE_EQ(most.damping, 45.0);
  EXPECT_DOUBLE_EQ(most.rotDamping, 0.05);
  most = haptics::stiffestGrasp(device, kPeriod, 4.5e-3);
  EXPECT_NEAR(most.stiffness, 200.0, 1e-9);
  EXPECT_NEAR(most.rotStiffness, 0.4, 1e-12);
  EXPECT_NEAR(most.rotDamping, 5e-5 / 5.5e-3, 1e-12);
  device.rate = 500.0;
  EXPECT_DOUBLE_EQ(haptics::stiffestGrasp(device, kPeriod, 0.0).rotStiffness, 2.0);
  device.maxTorque = 0.0;
  EXPECT_EQ(haptics::stiffestGrasp(device, kPeriod, 0.0).rotStiffness, 0.0);
  EXPECT_EQ(haptics::stiffestGrasp(device, kPeriod, 0.0).rotDamping, 0.0);
  device.maxForce = 0.0;
  EXPECT_EQ(haptics::stiffestGrasp(device, kPeriod, 0.0).stiffness, 0.0);
}

TEST(StiffestGrasp, BoundsTheDefaultsOfADevice) {
  haptics::TickParameters fitted;
  haptics::DeviceLimits device = SixAxisParameters{.inertia = 1e-5, .rotDamping = 1e-3}.limits();
  haptics::fitToDevice(device, 0.0, fitted);
  EXPECT_DOUBLE_EQ(fitted.graspStiffness, haptics::TickParameters{}.graspStiffness);
  EXPECT_DOUBLE_EQ(fitted.graspDamping, haptics::TickParameters{}.graspDamping);
  EXPECT_DOUBLE_EQ(fitted.graspRotStiffness, 2.0);
  EXPECT_DOUBLE_EQ(fitted.graspRotDamping, 0.01);
  EXPECT_DOUBLE_EQ(fitted.torqueLimit, 0.5);
  // Where the device drives no torque the turning spring is felt through the lever only, and stays.
  haptics::TickParameters three;
  device.maxTorque = 0.0;
  haptics::fitToDevice(device, 0.0, three);
  EXPECT_DOUBLE_EQ(three.graspRotStiffness, haptics::TickParameters{}.graspRotStiffness);
}

}  // namespace
}  // namespace tandem::test
