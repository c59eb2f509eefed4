// Two hands of one person at one part, or at two, led tick by tick.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <vector>

#include <glm/geometric.hpp>

#include "assets/base/allocation_counter.h"
#include "haptics/tick.h"
#include "tests/haptics/grasp/control_scenes.h"
#include "tests/haptics/hand_probe.h"
#include "tests/support/part_cases.h"
#include "tests/support/part_meshes.h"

namespace tandem::test {
namespace {

using haptics::PartCommand;
using Kind = haptics::PartCommand::Kind;

constexpr double kStiffness = 800.0;  // N/m, of both couplings
const glm::dquat kStraight(1.0, 0.0, 0.0, 0.0);

/// Two scripted devices in one scene.
class TwoHands {
 public:
  explicit TwoHands(assets::Scene given, const haptics::TickParameters& settings = springOnly(),
                    bool model = true)
      : parameters(settings),
        scene_(std::make_unique<assets::Scene>(std::move(given))),
        contact_(*scene_, 1) {
    if (model) contact_.modelParts();
    state = std::make_unique<haptics::TickState>(contact_);
    for (haptics::DeviceSample* sample : {&first, &second.device}) sample->valid = true;
  }

  void own(PartId part) { commands_.push_back({Kind::own, part, state->worldFromPart(part)}); }
  void grasp(PartId part, std::uint8_t hand) { commands_.push_back({Kind::grasp, part, {}, hand}); }
  void letGo(PartId part, std::uint8_t hand) { commands_.push_back({Kind::letGo, part, {}, hand}); }
  void disown(PartId part) { commands_.push_back({Kind::disown, part, {}}); }

  const haptics::TickOutput& tick(int count = 1) {
    for (int i = 0; i < count; ++i) {
      haptics::TickInput input;
      time_ += parameters.dt;
      first.time = second.device.time = time_;
      input.hands[0].device = first;
      input.commands = commands_;
      if (present) input.hands[1] = second, input.handCount = 2;
      const std::array<glm::dvec3, 2> before{out.hands[0].toHand.force, out.hands[1].toHand.force};
      const std::uint64_t used = allocationsOfThisThread();
      out = haptics::tick(input, contact_, parameters, *state);
      allocations += allocationsOfThisThread() - used;
      commands_.clear();
      steps[0] = std::max(steps[0], glm::length(out.hands[0].toHand.force - before[0]));
      steps[1] = std::max(steps[1], glm::length(out.hands[1].toHand.force - before[1]));
    }
    return out;
  }

  /// Leads both hands by these ways, m, in a straight line.
  void lead(const glm::dvec3& ofFirst, const glm::dvec3& ofSecond, int ticks) {
    first.twist.linear = ofFirst / (ticks * parameters.dt);
    second.device.twist.linear = ofSecond / (ticks * parameters.dt);
    for (int i = 0; i < ticks; ++i) {
      first.worldFromDevice.position += ofFirst / static_cast<double>(ticks);
      second.device.worldFromDevice.position += ofSecond / static_cast<double>(ticks);
      tick();
    }
    first.twist = second.device.twist = {};
  }

  void put(const glm::dvec3& ofFirst, const glm::dvec3& ofSecond) {
    first.worldFromDevice.position = ofFirst;
    second.device.worldFromDevice.position = ofSecond;
    tick();
  }

  glm::dvec3 place(PartId part = 0) const { return state->worldFromPart(part).position; }

  haptics::TickParameters parameters;
  haptics::DeviceSample first;
  haptics::HandInput second;
  bool present = true;  // the second hand
  haptics::TickOutput out;
  std::array<double, 2> steps{};  // N, the largest changes of force in a tick
  std::uint64_t allocations = 0;
  std::unique_ptr<haptics::TickState> state;

 private:
  std::unique_ptr<assets::Scene> scene_;
  haptics::ContactScene contact_;
  std::vector<PartCommand> commands_;
  double time_ = 0.0;
};

/// A bar of 80 mm along x and 0.1 kg with nothing about.
assets::Scene bar() {
  assets::Scene scene =
      sceneOfParts({{.name = "bar", .mesh = meshOf(boxSoup({0.08, 0.01, 0.01}, 3)), .movable = true}});
  const double moment = 0.1 / 12.0 * 0.0065;
  scene.parts[0].massProperties = {0.1, {0.0, 0.0, 0.0}, glm::dmat3(moment)};
  return scene;
}

/// A hand at each end of the bar.
std::unique_ptr<TwoHands> atBothEnds(const haptics::TickParameters& settings = springOnly()) {
  auto hands = std::make_unique<TwoHands>(bar(), settings);
  hands->put({-0.04, 0.0, 0.0}, {0.04, 0.0, 0.0});
  hands->own(0);
  hands->grasp(0, 0);
  hands->tick(5);
  hands->grasp(0, 1);
  hands->tick();
  return hands;
}

TEST(TwoHands, TakeOnePartWithoutForce) {
  const auto hands = atBothEnds();
  EXPECT_EQ(hands->out.hands[0].held, 0);
  EXPECT_EQ(hands->out.hands[1].held, 0);
  EXPECT_TRUE(hands->out.owned[0].held);
  EXPECT_LT(glm::length(hands->out.hands[0].toHand.force) + glm::length(hands->out.hands[1].toHand.force),
            1e-9);
}

TEST(TwoHands, PullAtEachOtherThroughThePartAsSpringsInSeries) {
  const auto hands = atBothEnds();
  hands->lead({-2e-3, 0.0, 0.0}, {2e-3, 0.0, 0.0}, 200);
  hands->tick(1000);
  EXPECT_NEAR(hands->out.hands[0].toHand.force.x, kStiffness * 2e-3, 1e-6);
  EXPECT_NEAR(hands->out.hands[1].toHand.force.x, -kStiffness * 2e-3, 1e-6);
  hands->lead({4e-3, 0.0, 0.0}, {0.0, 0.0, 0.0}, 200);
  hands->tick(1000);
  EXPECT_NEAR(hands->out.hands[0].toHand.force.x, 0.0, 1e-6);
  EXPECT_NEAR(hands->place().x, 2e-3, 1e-6);
}

TEST(TwoHands, TwistThePartAgainstEachOther) {
  const auto hands = atBothEnds();
  for (int i = 1; i <= 200; ++i) {
    hands->first.worldFromDevice.orientation = fromRotationVector({1e-3 * i, 0.0, 0.0});
    hands->second.device.worldFromDevice.orientation = fromRotationVector({-5e-4 * i, 0.0, 0.0});
    hands->tick();
  }
  hands->tick(1000);
  // The part stands midway between 0.2 and -0.1 rad.
  EXPECT_NEAR(rotationVector(hands->state->worldFromPart(0).orientation).x, 0.05, 2e-5);
  EXPECT_NEAR(hands->out.hands[0].toHand.torque.x, -4.0 * 0.15, 1e-5);
  EXPECT_NEAR(hands->out.hands[1].toHand.torque.x, 4.0 * 0.15, 1e-5);
}

TEST(TwoHands, ShareTheWeightAsTheirPlacesSay) {
  haptics::TickParameters p = springOnly();
  p.gravity = {0.0, 0.0, -9.81};
  p.graspRotStiffness = p.graspRotDamping = 0.0;  // else they bear moments too
  const auto hands = std::make_unique<TwoHands>(bar(), p);
  hands->put({-0.04, 0.0, 0.0}, {0.02, 0.0, 0.0});
  hands->own(0);
  hands->grasp(0, 0);
  hands->grasp(0, 1);
  hands->tick(4000);
  EXPECT_NEAR(hands->out.hands[0].toHand.force.z, -0.981 / 3.0, 2e-4);
  EXPECT_NEAR(hands->out.hands[1].toHand.force.z, -0.981 * 2.0 / 3.0, 2e-4);
}

TEST(TwoHands, LettingGoLeavesThePartInTheOtherHandWithoutAStep) {
  for (const std::uint8_t hand : {std::uint8_t{0}, std::uint8_t{1}}) {
    const auto hands = atBothEnds();
    hands->lead({-2e-3, 0.0, 0.0}, {2e-3, 0.0, 0.0}, 200);
    hands->tick(500);
    hands->steps = {};
    hands->letGo(0, hand);
    hands->tick();
    EXPECT_EQ(hands->out.hands[0].held, hand == 0 ? kNoPart : 0);
    EXPECT_EQ(hands->out.hands[1].held, hand == 1 ? kNoPart : 0);
    EXPECT_TRUE(hands->out.owned[0].held);
    hands->tick(1500);
    // 1.6 N in 0.3 s are 5.3 mN a tick; the slew limit would let 0.4 N pass.
    EXPECT_LT(hands->steps[0], 0.02) << int(hand);
    EXPECT_LT(hands->steps[1], 0.02) << int(hand);
    EXPECT_LT(glm::length(hands->out.hands[0].toHand.force) + glm::length(hands->out.hands[1].toHand.force),
              1e-3);
    EXPECT_NEAR(hands->place().x, hand == 0 ? 2e-3 : -2e-3, 1e-6);
    EXPECT_FALSE(hands->out.owned[0].atRest);
  }
}

TEST(TwoHands, WithoutAFadeLettingGoIsAStep) {
  // The control of the test above.
  haptics::TickParameters p = springOnly();
  p.fadeTime = 1e-6;
  const auto hands = atBothEnds(p);
  hands->lead({-2e-3, 0.0, 0.0}, {2e-3, 0.0, 0.0}, 200);
  hands->tick(500);
  hands->steps = {};
  hands->letGo(0, 1);
  hands->tick(100);
  EXPECT_GT(hands->steps[0], 0.08);
}

TEST(TwoHands, WhoLetsGoLastLeavesThePartWhereItIs) {
  const auto hands = atBothEnds();
  hands->lead({-2e-3, 0.0, 0.0}, {2e-3, 0.0, 0.0}, 200);
  hands->letGo(0, 0);
  hands->tick(20);
  hands->letGo(0, 1);
  hands->tick(400);
  EXPECT_FALSE(hands->out.owned[0].held);
  EXPECT_TRUE(hands->out.owned[0].atRest);
  const glm::dvec3 rest = hands->place();
  hands->tick(200);
  EXPECT_EQ(hands->place(), rest);
}

TEST(TwoHands, TakingThePartAwayEndsBothGrasps) {
  const auto hands = atBothEnds();
  hands->lead({-2e-3, 0.0, 0.0}, {2e-3, 0.0, 0.0}, 200);
  hands->steps = {};
  hands->disown(0);
  hands->tick(400);
  EXPECT_EQ(hands->out.hands[0].held, kNoPart);
  EXPECT_EQ(hands->out.hands[1].held, kNoPart);
  EXPECT_LT(std::max(hands->steps[0], hands->steps[1]), 0.01);
  EXPECT_EQ(hands->out.hands[1].toHand.force, glm::dvec3(0.0));
}

TEST(TwoHands, AHandWithoutAReadingIsWithoutForceAndTheOtherHoldsOn) {
  const auto hands = atBothEnds();
  hands->lead({-2e-3, 0.0, 0.0}, {2e-3, 0.0, 0.0}, 200);
  hands->second.device.valid = false;
  hands->tick();
  EXPECT_EQ(hands->out.hands[1].toHand.force, glm::dvec3(0.0));
  EXPECT_TRUE(hands->out.hands[1].flags & haptics::kFlagInvalidSample);
  EXPECT_FALSE(hands->out.flags & haptics::kFlagInvalidSample);
  EXPECT_GT(hands->out.hands[0].toHand.force.x, 1.0);
  hands->tick(1000);
  EXPECT_NEAR(hands->place().x, -2e-3, 1e-6);
  hands->second.device.valid = true;
  hands->tick(1000);
  EXPECT_NEAR(hands->out.hands[1].toHand.force.x, -kStiffness * 2e-3, 1e-6);
  // The first hand without a reading: the second one has it.
  hands->first.worldFromDevice.position.x = NAN;
  hands->tick(1000);
  EXPECT_EQ(hands->out.hands[0].toHand.force, glm::dvec3(0.0));
  EXPECT_NEAR(hands->place().x, 2e-3, 1e-6);
}

TEST(TwoHands, EachFeelsTheLimitsOfItsOwnDevice) {
  haptics::TickParameters weak = springOnly();
  weak.forceLimit = 0.5;
  weak.graspStiffness = 400.0;
  auto hands = std::make_unique<TwoHands>(bar());
  hands->second.parameters = &weak;
  hands->put({-0.04, 0.0, 0.0}, {0.04, 0.0, 0.0});
  hands->own(0);
  hands->grasp(0, 0);
  hands->grasp(0, 1);
  hands->tick();
  hands->lead({-3e-3, 0.0, 0.0}, {3e-3, 0.0, 0.0}, 200);
  hands->tick(1000);
  EXPECT_NEAR(hands->out.hands[0].toHand.force.x, 6e-3 / (1.0 / 800.0 + 1.0 / 400.0), 5e-4);
  EXPECT_NEAR(hands->out.hands[1].toHand.force.x, -0.5, 1e-9);
  EXPECT_TRUE(hands->out.hands[1].flags & haptics::kFlagForceLimited);
  EXPECT_FALSE(hands->out.flags & haptics::kFlagForceLimited);
}

TEST(TwoHands, ASecondHandThatHoldsNothingChangesNothing) {
  const auto run = [](bool present) {
    TwoHands hands(bar());
    hands.present = present;
    hands.put({-0.04, 0.0, 0.0}, {0.04, 0.0, 0.0});
    hands.own(0);
    hands.grasp(0, 0);
    hands.lead({0.01, 0.003, -0.002}, {0.0, 0.01, 0.0}, 150);
    return hands.out;
  };
  const haptics::TickOutput with = run(true), without = run(false);
  EXPECT_EQ(with.hands[0].toHand.force, without.hands[0].toHand.force);
  EXPECT_EQ(with.hands[0].toHand.torque, without.hands[0].toHand.torque);
  EXPECT_EQ(with.owned[0].worldFromPart.position, without.owned[0].worldFromPart.position);
  EXPECT_GT(glm::length(with.hands[0].toHand.force), 0.0);
  EXPECT_EQ(with.hands[1].toHand.force, glm::dvec3(0.0));
}

TEST(TwoHands, PressOnePartOnAnother) {
  // A cube in each hand, one on the other, as wide as the springs are pressed together.
  const CasePart low{.name = "low", .mesh = meshOf(boxSoup(glm::dvec3(0.02), 2)), .movable = true};
  const CasePart high{.name = "high",
                      .mesh = meshOf(boxSoup(glm::dvec3(0.02), 2)),
                      .worldFromPart = {{0.0, 0.0, 0.021}, kStraight},
                      .movable = true};
  TwoHands hands(sceneOfParts({low, high}));
  hands.put({0.0, 0.0, 0.0}, {0.0, 0.0, 0.021});
  hands.own(0);
  hands.own(1);
  hands.grasp(0, 0);
  hands.grasp(1, 1);
  hands.tick();
  EXPECT_EQ(hands.out.hands[0].held, 0);
  EXPECT_EQ(hands.out.hands[1].held, 1);
  hands.lead({0.0, 0.0, 2e-3}, {0.0, 0.0, -1e-3}, 200);
  hands.tick(500);
  EXPECT_NEAR(hands.out.hands[0].toHand.force.z, -kStiffness * 1e-3, 5e-3);
  EXPECT_NEAR(hands.out.hands[1].toHand.force.z, kStiffness * 1e-3, 5e-3);
  EXPECT_NEAR(hands.place(1).z - hands.place(0).z, 0.02, 5e-6);
  EXPECT_EQ(hands.allocations, 0u);
}

/// Two plates of 40 x 40 x 0.5 mm, `apart` m from each other, in a hand each.
std::unique_ptr<TwoHands> platesInBothHands(double apart) {
  std::vector<CasePart> parts;
  for (const double side : {-1.0, 1.0})
    parts.push_back({.name = side < 0.0 ? "lower" : "upper",
                     .mesh = meshOf(boxSoup({0.04, 0.04, 0.0005}, 2)),
                     .worldFromPart = {{0.0, 0.0, 0.5 * side * (apart + 0.0005)}, kStraight},
                     .movable = true,
                     .mass = 0.05});
  auto hands = std::make_unique<TwoHands>(sceneOfParts(parts));
  hands->put(hands->place(0), hands->place(1));
  for (const PartId part : {0u, 1u}) {
    hands->own(part);
    hands->grasp(part, static_cast<std::uint8_t>(part));
  }
  hands->tick();
  return hands;
}

TEST(TwoHands, PlatesThatTheyThrowAtEachOtherDoNotPass) {
  for (int i = 0; i < 18; ++i) {
    const double speed = std::array{0.2, 1.0, 2.0}[static_cast<std::size_t>(i % 3)];
    const auto hands = platesInBothHands(0.02 + 0.37e-3 * i);  // they meet at any share of a tick's way
    double least = 1.0;
    const double way = 0.018;  // m, each: their devices end beyond each other
    const int ticks = static_cast<int>(way / speed / hands->parameters.dt);
    for (int k = 0; k < ticks + 200; ++k) {
      if (k < ticks)
        hands->lead({0.0, 0.0, way / ticks}, {0.0, 0.0, -way / ticks}, 1);
      else
        hands->tick();
      least = std::min(least, hands->place(1).z - hands->place(0).z - 0.0005);
    }
    EXPECT_GT(least, -5e-6) << i;
    EXPECT_NEAR(hands->place(1).z - hands->place(0).z, 0.0005, 5e-6) << i;
  }
}

/// Parts that cannot touch each other are solved for by themselves.
TEST(TwoHands, WhatOneDoesFarAwayChangesNoBitForTheOther) {
  const auto forcesBeside = [](double speed) {
    std::vector<CasePart> parts{{.name = "table",
                                 .mesh = meshOf(boxSoup({0.1, 0.1, 0.02})),
                                 .worldFromPart = {{0.0, 0.0, -0.01}, kStraight},
                                 .friction = 0.3}};
    for (const double x : {0.0, 0.5})
      parts.push_back({.name = x > 0.0 ? "far" : "near",
                       .mesh = meshOf(boxSoup({0.01, 0.01, 0.01})),
                       .worldFromPart = {{x, 0.0, 0.006}, kStraight},
                       .movable = true,
                       .friction = 0.3,
                       .mass = 0.05});
    TwoHands hands(sceneOfParts(parts));
    hands.put(hands.place(2), hands.place(1));
    hands.own(1);
    hands.own(2);
    hands.grasp(2, 0);
    hands.grasp(1, 1);
    hands.tick();
    std::vector<double> forces;
    for (int i = 0; i < 300; ++i) {
      const double t = 0.001 * i;
      hands.lead({0.0, speed * std::sin(40.0 * t) * 0.001, 0.0}, {1e-5, 0.0, i < 100 ? -3e-5 : 0.0}, 1);
      for (int k = 0; k < 3; ++k) forces.push_back(hands.out.hands[1].toHand.force[k]);
    }
    EXPECT_GT(glm::length(hands.out.hands[1].toHand.force), 0.5);
    return forces;
  };
  EXPECT_EQ(forcesBeside(0.0), forcesBeside(2.0));
}

TEST(TwoHands, WhatTheBareToolFeltFadesWhenItTakesThePart) {
  TwoHands hands(bar());
  hands.put({-0.04, 0.0, 0.0}, {0.04, 0.0, 0.0});
  hands.own(0);
  hands.second.tool.force = {0.0, 0.0, 1.0};
  hands.tick(20);
  EXPECT_EQ(hands.out.hands[1].toHand.force.z, 1.0);
  hands.steps = {};
  hands.second.tool = {};
  hands.grasp(0, 1);
  hands.tick(100);
  EXPECT_GT(hands.out.hands[1].toHand.force.z, 0.5);
  hands.tick(300);
  EXPECT_EQ(hands.out.hands[1].toHand.force.z, 0.0);
  EXPECT_LT(hands.steps[1], 5e-3);
}

TEST(TwoHands, AControlIsInOneHandAtATime) {
  TwoHands hands(buttonScene(1.0).scene, springOnly(), false);
  hands.put({0.0, 0.0, 0.1}, {0.0, 0.01, 0.1});
  hands.own(0);
  hands.grasp(0, 0);
  hands.grasp(0, 1);
  hands.tick();
  EXPECT_EQ(hands.out.hands[0].held, 0);
  EXPECT_EQ(hands.out.hands[1].held, kNoPart);
  hands.letGo(0, 0);
  hands.grasp(0, 1);
  hands.tick();
  EXPECT_EQ(hands.out.hands[1].held, 0);
}

TEST(TwoHands, APartThatIsNotSimulatedHereIsNotTaken) {
  TwoHands hands(bar());
  hands.put({-0.04, 0.0, 0.0}, {0.04, 0.0, 0.0});
  hands.grasp(0, 1);
  hands.tick();
  EXPECT_EQ(hands.out.hands[1].held, kNoPart);
}

TEST(TwoHands, TheToolOfOneHandPressesOnWhatTheOtherHolds) {
  TwoHands hands(bar());
  hands.put({0.0, 0.0, 0.02}, {0.0, 0.0, 0.0});
  hands.own(0);
  hands.grasp(0, 1);
  hands.lead({0.0, 0.0, -0.017}, {0.0, 0.0, 0.0}, 400);  // 2 mm into it
  hands.tick(2000);
  EXPECT_NEAR(hands.out.hands[0].toHand.force.z, kStiffness * 1e-3, 5e-3);
  EXPECT_NEAR(hands.out.hands[1].toHand.force.z, -kStiffness * 1e-3, 5e-3);
  EXPECT_NEAR(hands.place().z, -1e-3, 1e-5);
}

}  // namespace
}  // namespace tandem::test
