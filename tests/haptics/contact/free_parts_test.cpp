// Parts that nobody holds and that move all the same: pushed, falling, coming to rest.

#include "assets/base/constants.h"
#include "tests/haptics/contact/moving_rig.h"
#include "tests/haptics/contact/part_contact_case.h"
#include "tests/support/part_meshes.h"

namespace tandem::test {
namespace {

const glm::dquat kStraight(1.0, 0.0, 0.0, 0.0);
const glm::dvec3 kGravity(0.0, 0.0, -9.81);

/// Cubes of 10 mm, one on the other with `gap` m between, above a block whose top is at z = 0.
assets::Scene stack(int cubes, double gap, double friction = 0.3) {
  std::vector<CasePart> parts;
  parts.push_back({.name = "table",
                   .mesh = meshOf(boxSoup({0.1, 0.1, 0.02})),
                   .worldFromPart = {{0, 0, -0.01}, kStraight},
                   .friction = friction});
  for (int i = 0; i < cubes; ++i)
    parts.push_back({.name = "cube" + std::to_string(i),
                     .mesh = meshOf(boxSoup({0.01, 0.01, 0.01})),
                     .worldFromPart = {{0, 0, 0.005 + gap + i * (0.01 + gap)}, kStraight},
                     .movable = true,
                     .friction = friction});
  return sceneOfParts(parts);
}

TEST(FreeParts, FallRestAndCostNothingOnceTheyDo) {
  MovingRig rig(stack(3, 0.004), kGravity);
  rig.at({{0.0, 0.0, 0.1}, kStraight});
  rig.tick();
  for (PartId cube = 1; cube <= 3; ++cube) rig.own(cube);
  rig.tick(100);
  EXPECT_LT(rig.pose(3).position.z, 0.033);  // it falls
  rig.tick(1500);
  for (PartId cube = 1; cube <= 3; ++cube) {
    EXPECT_NEAR(rig.pose(cube).position.z, 0.005 + 0.01 * (cube - 1), 5e-6) << cube;
    EXPECT_LT(std::hypot(rig.pose(cube).position.x, rig.pose(cube).position.y), 1e-5) << cube;
    EXPECT_TRUE(rig.owned(cube).atRest) << cube;
  }
  const Pose before = rig.pose(3);
  rig.tick(200);
  EXPECT_EQ(rig.pose(3).position, before.position);
}

TEST(FreeParts, WithoutGravityNothingFalls) {
  MovingRig rig(stack(1, 0.004));
  rig.at({{0.0, 0.0, 0.1}, kStraight});
  rig.tick();
  rig.own(1);
  const double height = rig.pose(1).position.z;
  rig.tick(300);
  EXPECT_EQ(rig.pose(1).position.z, height);
}

TEST(FreeParts, OneWithoutWeightSettlesAsWhereThereIsNoGravity) {
  // Thrown, and let go of in the air.
  const auto ticksToRest = [](const glm::dvec3& gravity) {
    assets::Scene scene = stack(1, 0.05);
    scene.parts[1].gravityFactor = 0.0;
    MovingRig rig(std::move(scene), gravity);
    const Pose start = rig.pose(1);
    rig.ownAndGrasp(1, start);
    rig.lead([&](double t) { return Pose{start.position + glm::dvec3(0.0, 0.3 * t, 0.0), kStraight}; }, 0.1);
    rig.letGo(1);
    int ticks = 0;
    do rig.tick();
    while (!rig.owned(1).atRest && ++ticks < 1000);
    return ticks;
  };
  EXPECT_EQ(ticksToRest(kGravity), ticksToRest(glm::dvec3(0.0)));
}

TEST(FreeParts, OneWithoutWeightIsNotWokenByWhatFallsOnIt) {
  assets::Scene scene = stack(3, 0.004);
  scene.parts[1].gravityFactor = 0.0;
  MovingRig rig(std::move(scene), kGravity);
  rig.at({{0.0, 0.0, 0.1}, kStraight});
  rig.tick();
  const double height = rig.pose(1).position.z;
  rig.own(1);
  rig.own(2);
  rig.own(3);
  rig.tick();
  bool touched = false;
  int awake = 0;
  rig.each = [&] {
    awake += rig.owned(1).atRest ? 0 : 1;
    touched = touched || !rig.contact().touches().empty();
  };
  rig.tick(150);
  EXPECT_TRUE(touched);
  EXPECT_EQ(awake, 0);
  EXPECT_EQ(rig.pose(1).position.z, height);
}

TEST(FreeParts, FallAsFastAsGravitySays) {
  MovingRig rig(stack(1, 0.05), kGravity);
  rig.at({{0.0, 0.0, 0.2}, kStraight});
  rig.tick();
  rig.own(1);
  rig.tick(90);
  // v = g t at the end of each step: half a step further than the parabola.
  EXPECT_NEAR(rig.pose(1).position.z, 0.055 - 0.5 * 9.81 * 0.09 * 0.091, 1e-8);
}

/// A table tilted by `angle` with one cube on it.
assets::Scene slope(double angle, double friction) {
  const glm::dquat tilt = fromRotationVector({0.0, angle, 0.0});
  return sceneOfParts({{.name = "slope",
                        .mesh = meshOf(boxSoup({0.4, 0.1, 0.02})),
                        .worldFromPart = {tilt * glm::dvec3(0.1, 0.0, -0.01), tilt},
                        .friction = friction},
                       {.name = "cube",
                        .mesh = meshOf(boxSoup({0.01, 0.01, 0.01})),
                        .worldFromPart = {tilt * glm::dvec3(0.0, 0.0, 0.005), tilt},
                        .movable = true,
                        .friction = friction}});
}

TEST(FreeParts, StayOnASlopeBelowTheAngleOfFrictionAndSlideAboveIt) {
  const double friction = 0.3, angle = std::atan(friction);
  for (const double share : {0.9, 1.2}) {
    MovingRig rig(slope(share * angle, friction), kGravity);
    rig.at({{0.0, 0.0, 0.2}, kStraight});
    rig.tick();
    rig.own(1);
    const glm::dvec3 start = rig.pose(1).position;
    rig.tick(300);
    const double displacement = glm::length(rig.pose(1).position - start);
    const double a = 9.81 * (std::sin(share * angle) - friction * std::cos(share * angle));
    if (share < 1.0)
      EXPECT_LT(displacement, 2e-6);
    else
      EXPECT_NEAR(displacement, 0.5 * a * 0.09, 0.02 * 0.5 * a * 0.09);
  }
}

/// A block, and a pin of 10 g beside it.
std::vector<CasePart> blockAndPin(double massOfBlock) {
  return {{.name = "block",
           .mesh = meshOf(boxSoup({0.06, 0.06, 0.06})),
           .worldFromPart = {{0.0, 0, 0.03}, kStraight},
           .movable = true,
           .mass = massOfBlock},
          {.name = "pin",
           .mesh = meshOf(boxSoup({0.04, 0.006, 0.006})),
           .worldFromPart = {{-0.051, 0, 0.03}, kStraight},
           .movable = true,
           .mass = 0.01}};
}

/// The pin in the hand, pushed against the block of 10 kg on a table without friction.
TEST(FreeParts, APinOfTenGramsMovesABlockOfTenKilogramsAsItsForceSays) {
  std::vector<CasePart> parts = blockAndPin(10.0);
  parts.push_back({.name = "table",
                   .mesh = meshOf(boxSoup({0.4, 0.4, 0.02})),
                   .worldFromPart = {{0, 0, -0.01}, kStraight}});
  MovingRig rig(sceneOfParts(parts), kGravity);
  const Pose grip = rig.pose(1);
  rig.at(grip);
  rig.tick();
  rig.own(0);
  rig.own(1);
  rig.grasp(1);
  rig.tick(400);  // the block settles
  const double before = rig.pose(0).position.x;
  double impulse = 0.0, displacement = 0.0, fastest = 0.0;
  rig.each = [&] {
    impulse -= rig.out.hands[0].toHand.force.x * rig.parameters.dt;
    displacement += impulse / 10.01 * rig.parameters.dt;
    fastest = std::max(fastest, std::abs(rig.owned(1).twist.linear.x));
  };
  rig.lead([&](double t) { return Pose{grip.position + glm::dvec3(0.02 * t, 0.0, 0.0), kStraight}; }, 0.3);
  rig.tick(200);
  const double speed = rig.owned(0).twist.linear.x;
  EXPECT_GT(impulse, 0.1);
  EXPECT_NEAR(10.01 * speed, impulse, 0.02 * impulse);
  EXPECT_NEAR(rig.pose(0).position.x - before, displacement, 0.02 * displacement);
  EXPECT_LT(std::abs(rig.pose(0).position.z - 0.03), 5e-6);
  EXPECT_LT(fastest, 0.1);
  EXPECT_EQ(rig.flags & haptics::kFlagFault, 0u);
}

/// The block's stated mass is a thousandth of the true one: the check above must fail.
TEST(FreeParts, ALightBlockIsPushedFarAway) {
  assets::Scene scene = sceneOfParts(blockAndPin(0.01));
  scene.joints.emplace_back();
  // Sliding on rails, so that it is free without gravity.
  scene.joints[0].partB = 0;
  scene.joints[0].bFromJoint = Pose{};
  scene.joints[0].aFromJoint = scene.parts[0].worldFromPart;
  scene.joints[0].limits = {{false, 6, 0.0, 0.0, 0.0, 0.0}, {true, 7, 0.0, 0.0, 0.0, 0.0}};
  MovingRig rig(std::move(scene));
  const Pose grip = rig.pose(1);
  rig.at(grip);
  rig.tick();
  rig.own(0);
  rig.own(1);
  rig.grasp(1);
  rig.tick(50);
  rig.lead([&](double t) { return Pose{grip.position + glm::dvec3(0.1 * t, 0.0, 0.0), kStraight}; }, 0.3);
  EXPECT_GT(rig.pose(0).position.x, 0.02);
  EXPECT_LT(rig.pose(0).position.x, 0.035);
}

TEST(FreeParts, TheToolPushesAPartThatItIsGivenAndNoOther) {
  for (const bool given : {true, false}) {
    MovingRig rig(stack(1, 0.0, 0.2), kGravity);
    rig.at({{-0.02, 0.0, 0.005}, kStraight});
    rig.tick();
    if (given) rig.each = [&] { rig.answer(); };
    // It slows down less than friction slows the cube, which would else slide on.
    const auto ease = [](double s) { return s * s * s * (10.0 - 15.0 * s + 6.0 * s * s); };
    rig.lead([&](double t) { return Pose{{-0.02 + 0.023 * ease(2.0 * t), 0.0, 0.005}, kStraight}; }, 0.5);
    rig.tick(100);
    EXPECT_NEAR(rig.pose(1).position.x, given ? 0.008 : 0.0, 1e-4);
    EXPECT_NEAR(rig.pose(1).position.z, 0.005, 1e-5);
    if (!given) {
      EXPECT_EQ(rig.out.pushed[0], 1);
    }
  }
}

TEST(FreeParts, AHeldPartPushesAStackThatIsAskedForPartByPart) {
  assets::Scene scene = stack(2, 0.0, 0.3);
  assets::Part pusher = scene.parts[1];
  pusher.name = "pusher";
  pusher.worldFromPart.position = {-0.012, 0.0, 0.0055};
  scene.parts.push_back(pusher);
  MovingRig rig(std::move(scene), kGravity);
  const Pose grip = rig.pose(3);
  rig.ownAndGrasp(3, grip);
  rig.each = [&] { rig.answer(); };
  rig.lead([&](double t) { return Pose{grip.position + glm::dvec3(0.012 * t, 0.0, 0.0), kStraight}; }, 0.5);
  EXPECT_EQ(rig.out.ownedCount, 3);
  rig.tick(50);
  for (const PartId cube : {PartId{1}, PartId{2}}) {
    EXPECT_NEAR(rig.pose(cube).position.x, 0.004, 2e-4) << cube;
    EXPECT_NEAR(rig.pose(cube).position.z, cube == 1 ? 0.005 : 0.015, 1e-5) << cube;
  }
  rig.lead(
      [&](double t) {
        return Pose{grip.position + glm::dvec3(0.006 - 0.012 * t, 0.0, 0.0), kStraight};
      },
      0.5);
  rig.tick(500);
  EXPECT_EQ(rig.out.ownedCount, 1);  // the others rest and are given back
  EXPECT_EQ(rig.out.pushedCount, 0);
}

TEST(FreeParts, AHeavyPartIsLedAsSlowlyAsTheHandLikes) {
  assets::Scene scene = sceneOfParts(
      {{.name = "cube", .mesh = meshOf(boxSoup({0.01, 0.01, 0.01})), .movable = true, .mass = 10.0}});
  MovingRig rig(std::move(scene));
  rig.ownAndGrasp(0, Pose{});
  rig.tick();
  const double speed = 1e-5;  // m/s
  double greatest = 0.0;
  rig.lead([&](double t) { return Pose{{speed * t, 0.0, 0.0}, kStraight}; }, 2.0);
  rig.each = [&] { greatest = std::max(greatest, std::abs(rig.out.hands[0].toHand.force.x)); };
  rig.lead([&](double t) { return Pose{{speed * (2.0 + t), 0.0, 0.0}, kStraight}; }, 2.0);
  // Its momentum swings on the hand's spring: 0.1 m/s kg at 10 rad/s and 4 N·s/m is 1 mN.
  EXPECT_LT(greatest, 4e-3);
  EXPECT_NEAR(rig.pose(0).position.x, 4e-5, 5e-6);
}

/// Two spur gears in the ratio 2:3 on shafts, the first one in the hand.
struct Gears {
  static assets::Scene scene(int teeth, double backlash) {
    SpurGear small, large;
    small.teeth = 2 * teeth;
    large.teeth = 3 * teeth;
    small.width = large.width = 0.004;
    small.flankPoints = large.flankPoints = 6;
    small.backlash = large.backlash = 0.5 * backlash;
    const double distance = 0.5 * small.module * (small.teeth + large.teeth);
    // A tooth of the first one in a gap of the second.
    const glm::dquat half = fromRotationVector({0.0, 0.0, kPi + kPi / large.teeth});
    assets::Scene scene =
        sceneOfParts({{.name = "small", .mesh = meshOf(spurGearSoup(small)), .movable = true},
                      {.name = "large",
                       .mesh = meshOf(spurGearSoup(large)),
                       .worldFromPart = {{distance, 0.0, 0.0}, half},
                       .movable = true}});
    for (PartId gear = 0; gear < 2; ++gear) {
      assets::Joint joint;
      joint.partB = gear;
      joint.bFromJoint.orientation = fromRotationVector({0.0, -0.5 * kPi, 0.0});
      joint.aFromJoint = scene.parts[gear].worldFromPart * joint.bFromJoint;
      joint.limits = {{false, 7, 0.0, 0.0, 0.0, 0.0}, {true, 6, 0.0, 0.0, 0.0, 0.0}};
      scene.joints.push_back(joint);
    }
    return scene;
  }
};

TEST(FreeParts, GearsTurnEachOtherInTheRatioOfTheirTeeth) {
  const double backlash = 1e-4;  // m of arc
  const int teeth = atFullSize() ? 10 : 6;
  const double turns = atFullSize() ? 3.0 : 0.5, seconds = 1.2 * turns;
  MovingRig rig(Gears::scene(teeth, backlash));
  const Pose grip{{0.0, 0.0, 0.002}, kStraight};
  rig.at(grip);
  rig.tick();
  rig.own(0);
  rig.own(1);
  rig.grasp(0);
  rig.tick(20);
  // The play of the driven gear, in rad.
  const double play = backlash / (0.001 * 3 * teeth);
  double greatest = -1e9, least = 1e9;
  bool driven = false;
  const double begin = rig.jointValue(1, true);
  rig.each = [&] {
    const double angle = rig.jointValue(0, true), answer = rig.jointValue(1, true) - begin;
    const double error = answer + angle * 2.0 / 3.0;
    driven = driven || std::abs(angle) > 0.3;
    if (!driven) return;
    greatest = std::max(greatest, error);
    least = std::min(least, error);
  };
  rig.lead(
      [&](double t) {
        return Pose{grip.position, fromRotationVector({0.0, 0.0, 2.0 * kPi * turns * t / seconds})};
      },
      seconds);
  EXPECT_NEAR(rig.jointValue(0, true), 2.0 * kPi * turns, 0.1);
  EXPECT_LT(greatest - least, 1.2 * play);
  EXPECT_LT(std::max(std::abs(greatest), std::abs(least)), 1.2 * play);
  EXPECT_EQ(rig.flags & haptics::kFlagFault, 0u);
}

}  // namespace
}  // namespace tandem::test
