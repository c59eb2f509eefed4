// A part in the hand that a joint holds: goes where the joint lets it, and feels the rest.

#include "assets/base/constants.h"
#include "tests/haptics/contact/moving_rig.h"
#include "tests/support/part_meshes.h"

namespace tandem::test {
namespace {

using assets::Joint;
using assets::JointLimit;

constexpr std::uint8_t kX = 1, kY = 2, kZ = 4;

JointLimit linear(std::uint8_t axes, double min = 0.0, double max = 0.0) {
  return {false, axes, min, max, 0.0, 0.0};
}
JointLimit angular(std::uint8_t axes, double min = 0.0, double max = 0.0) {
  return {true, axes, min, max, 0.0, 0.0};
}

/// A lever of 60 x 10 x 10 mm whose joint to the world stands at its left end, the joint's X axis along
/// `axis`.
assets::Scene lever(std::vector<JointLimit> limits,
                    const glm::dquat& worldFromJoint = glm::dquat(1, 0, 0, 0)) {
  assets::Scene scene =
      sceneOfParts({{.name = "lever", .mesh = meshOf(boxSoup({0.06, 0.01, 0.01})), .movable = true}});
  Joint joint;
  joint.name = "joint";
  joint.partA = kNoPart;
  joint.partB = 0;
  joint.aFromJoint = {{-0.03, 0.0, 0.0}, worldFromJoint};
  joint.bFromJoint = joint.aFromJoint;
  joint.limits = std::move(limits);
  scene.joints.push_back(joint);
  return scene;
}

/// X to world Z: a hinge that turns in the plane.
const glm::dquat kUpright = fromRotationVector({0.0, -0.5 * kPi, 0.0});

/// The rig with the lever in the hand, held at its right end.
struct Lever {
  explicit Lever(assets::Scene scene) : rig(std::move(scene)) {
    rig.ownAndGrasp(0, grip);
    rig.tick();
  }
  /// Leads the hand along a straight path and through a rotation, over 0.5 s.
  void to(const glm::dvec3& by, const glm::dvec3& rotation = glm::dvec3(0.0), double seconds = 0.5) {
    const Pose from = grip;
    const auto path = [&](double t) {
      const double s = t / seconds, ease = s * s * s * (10.0 - 15.0 * s + 6.0 * s * s);
      return Pose{from.position + ease * by, fromRotationVector(ease * rotation) * from.orientation};
    };
    rig.lead(path, seconds);
    grip = path(seconds);
    rig.at(grip);
    rig.tick(1500);
  }
  /// Where the joint's frame in the lever is, seen from that in the world.
  Pose off() const {
    const Joint& joint = rig.scene().joints[0];
    return inverse(joint.aFromJoint) * (rig.pose(0) * joint.bFromJoint);
  }
  Pose grip{{0.03, 0.0, 0.0}, glm::dquat(1, 0, 0, 0)};
  MovingRig rig;
};

constexpr double kFirm = 1e-9;  // m

TEST(Joints, AHingeTurnsAboutItsAxisOnly) {
  Lever lever_(lever({linear(kX | kY | kZ), angular(kY | kZ)}, kUpright));
  double worst = 0.0, askew = 0.0;
  lever_.rig.each = [&] {
    const Pose off = lever_.off();
    worst = std::max(worst, glm::length(off.position));
    const glm::dvec3 x = off.orientation * glm::dvec3(1.0, 0.0, 0.0);
    askew = std::max(askew, glm::length(glm::dvec3(0.0, x.y, x.z)));
  };
  // A quarter of a turn, and pulled outwards and up besides.
  lever_.to({-0.06, 0.08, 0.02}, {0.0, 0.0, 0.5 * kPi});
  EXPECT_LT(worst, 2e-6);
  EXPECT_LT(askew, 1e-4);
  const glm::dvec3 end = transformPoint(lever_.rig.pose(0), {0.03, 0.0, 0.0});
  EXPECT_LT(glm::length(end - glm::dvec3(-0.03, 0.06, 0.0)), 1e-4);
  EXPECT_LT(glm::length(lever_.off().position), 1e-7);
  // The hand feels what the hinge locks: 20 mm beyond the circle, and 20 mm up.
  EXPECT_NEAR(lever_.rig.out.hands[0].toHand.force.y, -20.0, 0.3);
  EXPECT_NEAR(lever_.rig.out.hands[0].toHand.force.z, -20.0, 0.3);
}

TEST(Joints, WithoutOneTheLeverGoesWithTheHand) {
  assets::Scene scene = lever({});
  scene.joints.clear();
  Lever lever_{std::move(scene)};
  lever_.to({0.0, 0.0, 0.02});
  EXPECT_NEAR(lever_.rig.pose(0).position.z, 0.02, 1e-5);
}

TEST(Joints, AHingeStopsAtItsLimits) {
  Lever lever_(lever({linear(kX | kY | kZ), angular(kY | kZ), angular(kX, -0.3, 0.5)}, kUpright));
  lever_.to({-0.03, 0.05, 0.0}, {0.0, 0.0, 1.5});
  EXPECT_NEAR(lever_.rig.jointValue(0, true), 0.5, 1e-6);
  lever_.to({0.03, -0.1, 0.0}, {0.0, 0.0, -2.5});
  EXPECT_NEAR(lever_.rig.jointValue(0, true), -0.3, 1e-6);
}

TEST(Joints, ASliderGoesAlongItsAxisBetweenItsStops) {
  Lever lever_(lever({linear(kY | kZ), linear(kX, -0.01, 0.04), angular(kX | kY | kZ)}));
  lever_.to({0.02, 0.01, 0.005}, {0.1, 0.1, 0.1});
  EXPECT_NEAR(lever_.rig.pose(0).position.x, 0.02, 1e-5);
  EXPECT_LT(std::hypot(lever_.rig.pose(0).position.y, lever_.rig.pose(0).position.z), kFirm);
  EXPECT_NEAR(lever_.rig.out.hands[0].toHand.force.y, -10.0, 1e-3);
  lever_.to({0.05, 0.0, 0.0});
  EXPECT_NEAR(lever_.rig.pose(0).position.x, 0.04, kFirm);
  EXPECT_NEAR(lever_.rig.out.hands[0].toHand.force.x, -30.0, 1e-3);  // 30 mm beyond the stop
}

TEST(Joints, ACylinderTurnsAndSlides) {
  Lever lever_(lever({linear(kY | kZ), angular(kY | kZ)}));
  lever_.to({0.02, 0.0, 0.0}, {1.0, 0.0, 0.0});
  EXPECT_NEAR(lever_.rig.pose(0).position.x, 0.02, 1e-5);
  EXPECT_NEAR(lever_.rig.jointValue(0, true), 1.0, 1e-4);
  EXPECT_LT(glm::length(lever_.rig.out.hands[0].toHand.force), 0.02);
}

TEST(Joints, ABallHoldsAPointAndAConeItsTilt) {
  Lever ball(lever({linear(kX | kY | kZ)}));
  ball.to({-0.02, 0.03, 0.03}, {0.7, -0.6, 0.8});
  EXPECT_LT(glm::length(ball.off().position), 1e-7);
  EXPECT_GT(glm::length(rotationVector(ball.off().orientation)), 0.8);
  Lever cone(lever({linear(kX | kY | kZ), angular(kY | kZ, 0.0, 0.25)}));
  cone.to({-0.02, 0.03, 0.03}, {0.7, -0.6, 0.8});
  const glm::dvec3 x = cone.off().orientation * glm::dvec3(1.0, 0.0, 0.0);
  EXPECT_NEAR(std::acos(x.x), 0.25, 1e-5);
}

TEST(Joints, AFixedPartStaysWhereItIsAndTheHandFeelsItsPull) {
  Lever lever_(lever({linear(kX | kY | kZ), angular(kX | kY | kZ)}));
  lever_.to({0.01, 0.02, -0.01}, {0.2, 0.1, -0.1});
  EXPECT_LT(glm::length(lever_.rig.pose(0).position), kFirm);
  EXPECT_LT(glm::length(rotationVector(lever_.rig.pose(0).orientation)), 1e-7);
  EXPECT_LT(glm::length(lever_.rig.out.hands[0].toHand.force - glm::dvec3(-10.0, -20.0, 10.0)), 1e-6);
}

TEST(Joints, AStraightCordLetsItComeNearerOnly) {
  Lever lever_(lever({linear(kX | kY | kZ, 0.0, 0.015)}));
  lever_.to({0.0, 0.0, 0.01});
  EXPECT_NEAR(lever_.rig.pose(0).position.z, 0.01, 1e-5);
  lever_.to({0.0, 0.0, 0.02});
  EXPECT_NEAR(glm::length(lever_.off().position), 0.015, 1e-7);
}

/// The thread of an M16 bolt, 2 mm a turn, ten turns by hand.
TEST(Joints, AScrewGoesItsPitchATurnForManyTurns) {
  for (const double pitch : {0.002, -0.002}) {
    assets::Scene scene = lever({linear(kY | kZ), angular(kY | kZ)});
    scene.joints[0].pitch = pitch;
    Lever lever_{std::move(scene)};
    double worst = 0.0;
    lever_.rig.each = [&] {
      const double rotation = lever_.rig.jointValue(0, true), displacement = lever_.rig.jointValue(0, false);
      worst = std::max(worst, std::abs(displacement - pitch * rotation / (2.0 * kPi)));
    };
    const Pose grip = lever_.grip;
    lever_.rig.lead(
        [&](double t) {
          const double rotation = 20.0 * kPi * t / 5.0;
          return Pose{grip.position + glm::dvec3(pitch * rotation / (2.0 * kPi), 0.0, 0.0),
                      fromRotationVector({rotation, 0.0, 0.0}) * grip.orientation};
        },
        5.0);
    lever_.rig.tick(1000);
    EXPECT_NEAR(lever_.rig.jointValue(0, true), 20.0 * kPi, 1e-3) << pitch;
    EXPECT_NEAR(lever_.rig.pose(0).position.x, 10.0 * pitch, 1e-6) << pitch;
    EXPECT_LT(worst, 5e-6) << pitch;
    EXPECT_EQ(lever_.rig.flags & (haptics::kFlagOverflow | haptics::kFlagFault), 0u);
  }
}

TEST(Joints, PushingAScrewWithoutFrictionTurnsIt) {
  assets::Scene scene = lever({linear(kY | kZ), angular(kY | kZ)});
  scene.joints[0].pitch = 0.05;  // steep
  Lever lever_{std::move(scene)};
  lever_.rig.parameters.graspRotStiffness = 0.0;
  lever_.to({0.01, 0.0, 0.0});
  EXPECT_NEAR(lever_.rig.jointValue(0, true), 2.0 * kPi * lever_.rig.pose(0).position.x / 0.05, 1e-4);
  EXPECT_GT(lever_.rig.jointValue(0, true), 0.5);
}

TEST(Joints, ADriveIsASpringInSeriesWithTheHand) {
  assets::Scene scene = lever({linear(kY | kZ), angular(kX | kY | kZ)});
  assets::JointDrive drive;
  drive.stiffness = 500.0;
  drive.damping = 5.0;
  scene.joints[0].drives.push_back(drive);
  Lever weak(scene);
  weak.to({0.03, 0.0, 0.0});
  EXPECT_NEAR(weak.rig.pose(0).position.x, 0.02, 1e-5);  // 1000 N/m against 500
  EXPECT_NEAR(weak.rig.out.hands[0].toHand.force.x, -10.0, 0.01);
  scene.joints[0].drives[0].maxForce = 4.0;
  Lever limited(scene);
  limited.to({0.03, 0.0, 0.0});
  EXPECT_NEAR(limited.rig.out.hands[0].toHand.force.x, -4.0, 0.01);
}

TEST(Joints, ASoftLimitIsASpringBehindIt) {
  assets::Scene scene = lever({linear(kY | kZ), angular(kX | kY | kZ)});
  scene.joints[0].limits.push_back({false, kX, -1.0, 0.01, 2000.0, 2.0});
  Lever lever_{std::move(scene)};
  lever_.to({0.009, 0.0, 0.0});
  EXPECT_NEAR(lever_.rig.out.hands[0].toHand.force.x, 0.0, 0.02);
  lever_.to({0.031, 0.0, 0.0});  // 30 mm beyond the limit
  EXPECT_NEAR(lever_.rig.pose(0).position.x, 0.02, 1e-5);
  EXPECT_NEAR(lever_.rig.out.hands[0].toHand.force.x, -20.0, 0.02);
}

TEST(Joints, DetentsSnapThePartToTheNearestPlace) {
  assets::Scene scene = lever({linear(kY | kZ), angular(kX | kY | kZ)});
  scene.joints[0].detents = {{0.0, 0.01, 0.02}, 4.0, 0.01};
  Lever lever_{std::move(scene)};
  lever_.rig.parameters.graspStiffness = 300.0;
  lever_.to({0.003, 0.0, 0.0});
  EXPECT_LT(lever_.rig.pose(0).position.x, 0.0015);
  lever_.to({0.007, 0.0, 0.0});  // 10 mm: less than the 13 mm of spring that the 4 N of a place take
  EXPECT_LT(lever_.rig.pose(0).position.x, 0.0025);
  lever_.to({0.007, 0.0, 0.0});
  lever_.rig.letGo(0);
  lever_.rig.tick(500);
  EXPECT_NEAR(lever_.rig.pose(0).position.x, 0.01, 2e-4);
}

}  // namespace
}  // namespace tandem::test
