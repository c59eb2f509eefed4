// One part in two hands, each on a device of six axes of its own, closed through one tick. How stiff may the
// two couplings be? What is summed up is what couplings and devices of both hands have given out together:
// energy may go from one hand to the other, but none may come from nowhere.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>

#include <glm/geometric.hpp>

#include "haptics/body/virtual_coupling.h"
#include "haptics/tick.h"
#include "tests/haptics/contact/part_contact_case.h"
#include "tests/haptics/grasp/closed_loop_case.h"
#include "tests/support/part_meshes.h"
#include "tests/support/six_axis_device.h"

namespace tandem::test {
namespace {

/// What one hand does.
struct Hand {
  Pose grip;           // world
  Wrench push{};       // from the first tick on
  Twist start{};       // of its device
  double letGo = 1e6;  // s
};

struct TwoHold {
  TwoHold(const char* label, assets::Scene given, const glm::dvec3& first, const glm::dvec3& second)
      : name(label), scene(std::make_unique<assets::Scene>(std::move(given))), contact(*scene, 1) {
    contact.modelParts();
    for (int i = 0; i < 2; ++i)
      hands[i].grip = scene->parts[0].worldFromPart * Pose{i == 0 ? first : second, {1.0, 0.0, 0.0, 0.0}};
  }
  const char* name;
  std::unique_ptr<assets::Scene> scene;
  haptics::ContactScene contact;
  Hand hands[2];
};

// As in grasp_closed_loop_test: the hand's own spring, without damping, only keeps the device about where it
// started.

Wrench pushOf(const Hand& hand, const Pose& device) {
  const glm::dvec3 turn = rotationVector(device.orientation * glm::conjugate(hand.grip.orientation));
  return {hand.push.force - kHandStiffness * (device.position - hand.grip.position),
          hand.push.torque - kHandRotStiffness * turn};
}

CasePart barPart() { return {"bar", meshOf(boxSoup({0.08, 0.01, 0.01}, 3)), {}, true}; }

/// A bar of 80 mm with a hand at each end and nothing about, thrown.
TwoHold inTheAir() {
  TwoHold hold("air", sceneOfParts({barPart(), block({9.0, 0.0, 0.0})}), {-0.04, 0.0, 0.0}, {0.04, 0.0, 0.0});
  hold.hands[0].start = {{0.1, -0.05, 0.1}, {2.0, -1.0, 3.0}};
  hold.hands[1].start = {{-0.1, 0.05, 0.05}, {-3.0, 1.0, 1.0}};
  return hold;
}

/// The same bar pressed down on the edge of a block and against a wall.
TwoHold againstAWall() {
  TwoHold hold("wall", sceneOfParts({barPart(), block({-0.02, 0.0, -0.035}), block({0.0, -0.035, 0.0})}),
               {-0.04, 0.0, 0.0}, {0.04, 0.0, 0.0});
  hold.hands[0].push.force = {0.0, -1.0, -1.0};
  hold.hands[1].push.force = {0.0, -1.0, -0.5};
  return hold;
}

/// A cube pushed into the corner of three blocks by both: each device swings against a part that does not
/// give way.
TwoHold inACorner() {
  TwoHold hold("corner",
               sceneOfParts({{"cube", meshOf(boxSoup(glm::dvec3(0.02), 2)), {}, true},
                             block({0.0, 0.0, -0.04}),
                             block({-0.04, 0.0, 0.0}),
                             block({0.0, -0.04, 0.0})}),
               {0.004, 0.003, 0.005}, {-0.003, 0.004, 0.004});
  hold.hands[0].push.force = {-1.0, -1.0, -1.0};
  hold.hands[1].push.force = {-0.7, -1.2, -0.8};
  return hold;
}

/// The bar in the air, twisted and pulled against each other.
TwoHold twisted() {
  TwoHold hold = inTheAir();
  hold.name = "twisted";
  for (Hand& hand : hold.hands) hand.start = {};
  hold.hands[0].push = {{-1.0, 0.3, 0.0}, {0.08, 0.05, 0.0}};
  hold.hands[1].push = {{1.0, -0.3, 0.0}, {-0.08, -0.05, 0.02}};
  return hold;
}

struct TwoHandLoop {
  SixAxisParameters devices[2];
  double share[2] = {0.9, 0.9};  // of each device's own limits
  bool swapped = false;          // each gets the limits of the other one
  double seconds = 2.0;
  int early = 1;  // the eighth that the last one is compared with
};

struct TwoHandOutcome {
  double early = 0.0, late = 0.0;  // m, peak to peak of the devices, in an early and the last eighth
  double earlyTurn = 0.0, lateTurn = 0.0;
  double created = 0.0;  // J, the most that both gave out together beyond what came in
};

haptics::TickParameters parametersOfHand(const TwoHandLoop& loop, int hand) {
  const haptics::CouplingGains most =
      haptics::stiffestGrasp(loop.devices[loop.swapped ? 1 - hand : hand].limits(), kPeriod, 0.0);
  haptics::TickParameters p = rigParameters();
  p.slewLimit = p.torqueSlewLimit = 1e9;
  p.graspStiffness = loop.share[hand] * most.stiffness;
  p.graspRotStiffness = loop.share[hand] * most.rotStiffness;
  p.graspDamping = p.graspRotDamping = 0.0;
  return p;
}

TwoHandOutcome runBothHands(const TwoHold& hold, const TwoHandLoop& loop) {
  using Kind = haptics::PartCommand::Kind;
  haptics::TickState state(hold.contact);
  const haptics::TickParameters parameters[2] = {parametersOfHand(loop, 0), parametersOfHand(loop, 1)};
  SixAxisDevice devices[2] = {{loop.devices[0], hold.hands[0].grip}, {loop.devices[1], hold.hands[1].grip}};
  for (int h = 0; h < 2; ++h) devices[h].setTwist(hold.hands[h].start);
  const int ticks = static_cast<int>(loop.seconds / kPeriod), eighth = ticks / 8;
  Extent place[2][2], turn[2][2];
  TwoHandOutcome outcome;
  for (int i = 0; i < ticks; ++i) {
    const double now = kPeriod * i;
    haptics::TickInput input;
    input.hands[0].device = devices[0].sample(now, kPeriod);
    input.hands[1] = {devices[1].sample(now, kPeriod), &parameters[1], {}};
    input.handCount = 2;
    std::vector<haptics::PartCommand> commands;
    if (i == 0)
      commands = {
          {Kind::own, 0, hold.scene->parts[0].worldFromPart}, {Kind::grasp, 0, {}}, {Kind::grasp, 0, {}, 1}};
    for (std::uint8_t h = 0; h < 2; ++h)
      if (i > 0 && i == static_cast<int>(hold.hands[h].letGo / kPeriod))
        commands.push_back({Kind::letGo, 0, {}, h});
    input.commands = commands;
    const haptics::TickOutput out = haptics::tick(input, hold.contact, parameters[0], state);
    const Wrench sent[2] = {out.hands[0].toHand, out.hands[1].toHand};
    for (int h = 0; h < 2; ++h) devices[h].step(sent[h], pushOf(hold.hands[h], devices[h].pose()), kPeriod);
    outcome.created = std::max(outcome.created, devices[0].given() + devices[1].given());
    const int window = i / eighth == loop.early ? 0 : i >= ticks - eighth ? 1 : -1;
    for (int h = 0; h < 2; ++h) {
      const Pose& pose = devices[h].pose();
      if (!(glm::length(pose.position) < 10.0)) return {0.0, 1e9, 0.0, 1e9, outcome.created};
      if (window < 0) continue;
      place[window][h].note(pose.position);
      turn[window][h].note(rotationVector(pose.orientation));
    }
  }
  outcome.early = std::max(place[0][0].size(), place[0][1].size());
  outcome.late = std::max(place[1][0].size(), place[1][1].size());
  outcome.earlyTurn = std::max(turn[0][0].size(), turn[0][1].size());
  outcome.lateTurn = std::max(turn[1][0].size(), turn[1][1].size());
  return outcome;
}

void printBothHands(const TwoHold& hold, const TwoHandLoop& loop, const TwoHandOutcome& o) {
  if (!atFullSize()) return;
  std::printf(
      "%-8s %4.2f and %4.2f of the limits, quantum %.3g mm: way %8.3g -> %8.3g mm, turn %8.3g -> %8.3g mrad, "
      "created "
      "%8.3g J\n",
      hold.name, loop.share[0], loop.share[1], 1e3 * loop.devices[0].quantum, 1e3 * o.early, 1e3 * o.late,
      1e3 * o.earlyTurn, 1e3 * o.lateTurn, o.created);
}

void expectBothRest(const TwoHold& hold, const TwoHandLoop& loop) {
  const TwoHandOutcome o = runBothHands(hold, loop);
  printBothHands(hold, loop, o);
  const SixAxisParameters& d = loop.devices[0];
  EXPECT_LT(o.late, std::max(0.6 * o.early, 4.0 * d.quantum + 1e-6)) << hold.name;
  EXPECT_LT(o.lateTurn, std::max(0.6 * o.earlyTurn, 4.0 * d.rotQuantum + 1e-4)) << hold.name;
  EXPECT_LE(o.created, kRounding) << hold.name;
}

void expectBothRestUpToTheLimits(const TwoHold& hold) {
  if (atFullSize()) {
    for (const double share : {0.3, 0.5, 0.7, 0.8}) {
      TwoHandLoop loop;
      loop.share[0] = share;
      expectBothRest(hold, loop);
    }
  }
  TwoHandLoop loop;
  expectBothRest(hold, loop);
  for (SixAxisParameters& device : loop.devices) device.quantum = 0.055e-3, device.rotQuantum = 1e-3;
  expectBothRest(hold, loop);
}

/// Two devices that differ: the second is heavier, and damps three times as much.
TwoHandLoop unequal() {
  TwoHandLoop loop;
  loop.devices[1].mass = 0.09;
  loop.devices[1].inertia = 1e-4;
  loop.devices[1].damping = 3.0;
  loop.devices[1].rotDamping = 6e-3;
  return loop;
}

TEST(TwoHandsClosedLoop, ABarInTheAirRestsUpToNineTenthsOfBothLimits) {
  expectBothRestUpToTheLimits(inTheAir());
}
TEST(TwoHandsClosedLoop, ABarAgainstAWallRestsUpToNineTenthsOfBothLimits) {
  expectBothRestUpToTheLimits(againstAWall());
}
TEST(TwoHandsClosedLoop, ACubeInACornerRestsUpToNineTenthsOfBothLimits) {
  expectBothRestUpToTheLimits(inACorner());
}
TEST(TwoHandsClosedLoop, ABarThatIsTwistedRestsUpToNineTenthsOfBothLimits) {
  expectBothRestUpToTheLimits(twisted());
}

TEST(TwoHandsClosedLoop, EachCouplingHasTheLimitOfItsOwnDevice) {
  for (TwoHold (*const make)() : {inTheAir, inACorner, twisted}) expectBothRest(make(), unequal());
}

TEST(TwoHandsClosedLoop, WithTheLimitsOfTheOtherDeviceAHandSwingsAndMakesEnergy) {
  // The control of the test above.
  TwoHandLoop loop = unequal();
  loop.swapped = true;
  const TwoHold hold = inACorner();
  const TwoHandOutcome o = runBothHands(hold, loop);
  printBothHands(hold, loop, o);
  EXPECT_GT(o.created, 1e-5);
  EXPECT_GT(o.late, 1e-3);
}

TEST(TwoHandsClosedLoop, OneHandAboveItsLimitSwingsAndMakesEnergy) {
  for (const int hand : {0, 1}) {
    TwoHandLoop loop;
    loop.share[hand] = 1.2;
    const TwoHold hold = inACorner();
    const TwoHandOutcome o = runBothHands(hold, loop);
    printBothHands(hold, loop, o);
    EXPECT_GT(o.created, 1e-5) << hand;
    EXPECT_GT(o.late, 1e-3) << hand;
    EXPECT_GT(o.late, 0.9 * o.early) << hand;
  }
}

TEST(TwoHandsClosedLoop, OneThatLetsGoInTensionLeavesTheOtherAtRestAndMakesNoEnergy) {
  const auto expect = [](TwoHold hold, int hand) {
    hold.hands[hand].letGo = 0.8;
    TwoHandLoop loop;
    loop.seconds = 2.4;
    loop.early = 3;  // from 0.9 s on
    expectBothRest(hold, loop);
  };
  for (const int hand : {0, 1}) expect(twisted(), hand);
  expect(inACorner(), 0);
}

}  // namespace
}  // namespace tandem::test
