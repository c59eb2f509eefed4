#include "haptics/operator/impedance_arm.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>
#include <random>

#include "haptics/body/virtual_coupling.h"
#include "haptics/devices/device_list.h"
#include "haptics/devices/simulated_arm.h"

namespace tandem::haptics {
namespace {

using glm::dvec3;

/// Joints anywhere in the ranges of the default arm.
class Joints {
 public:
  ArmJoints next() {
    ArmJoints joints;
    joints.arm.x = in(-0.98, 0.98);
    joints.arm.y = in(0.0, 1.75);
    joints.arm.z = std::min(2.5, joints.arm.y + in(-0.81, 1.25));
    joints.gimbal = {in(-2.5, 2.5), in(-1.4, 1.4), in(-2.5, 2.5)};
    return joints;
  }
  dvec3 vector(double size) { return {in(-size, size), in(-size, size), in(-size, size)}; }

 private:
  double in(double low, double high) { return std::uniform_real_distribution(low, high)(random_); }
  std::mt19937 random_{7};
};

TEST(ImpedanceArm, PutsTheTipWhereThePublishedEquationsDo) {
  const ImpedanceArm arm;
  // q = 0: upper arm forwards, forearm down.
  EXPECT_NEAR(glm::distance(arm.tip({}).position, dvec3(0.0, -0.11, -0.035)), 0.0, 1e-15);
  // Upper arm up, forearm forwards, base a quarter turn: to the left.
  const double right = std::numbers::pi / 2;
  EXPECT_NEAR(glm::distance(arm.tip({{right, right, right}, {}}).position, dvec3(-0.135, 0.16, -0.17)), 0.0,
              1e-15);
}

TEST(ImpedanceArm, JacobiansAreTheDerivativesOfTheTipsPose) {
  const ImpedanceArm arm;
  Joints joints;
  constexpr double kStep = 1e-5;
  for (int round = 0; round < 200; ++round) {
    const ArmJoints q = joints.next();
    const glm::dmat3 linear = arm.jacobian(q.arm);
    glm::dmat3 turned, gimballed;
    arm.angularJacobian(q, turned, gimballed);
    for (int i = 0; i < 6; ++i) {
      ArmJoints up = q, down = q;
      (i < 3 ? up.arm[i] : up.gimbal[i - 3]) += kStep;
      (i < 3 ? down.arm[i] : down.gimbal[i - 3]) -= kStep;
      const Pose a = arm.tip(down), b = arm.tip(up);
      const dvec3 moved = (b.position - a.position) / (2.0 * kStep);
      const dvec3 turn = rotationVector(b.orientation * glm::conjugate(a.orientation)) / (2.0 * kStep);
      const dvec3 noMotion(0.0);
      EXPECT_LT(glm::distance(moved, i < 3 ? linear[i] : noMotion), 1e-9) << i;
      EXPECT_LT(glm::distance(turn, i < 3 ? turned[i] : gimballed[i - 3]), 1e-8) << i;
    }
  }
}

TEST(ImpedanceArm, FindsTheJointsOfATipInRange) {
  const ImpedanceArm arm;
  Joints joints;
  for (int round = 0; round < 1000; ++round) {
    const ArmJoints q = joints.next();
    const ArmJoints found = arm.jointsFor(arm.tip(q));
    ASSERT_LT(glm::distance(found.arm, q.arm), 1e-9);
    ASSERT_LT(glm::distance(found.gimbal, q.gimbal), 1e-9);
  }
}

TEST(ImpedanceArm, TorqueTimesJointSpeedIsForceTimesTipSpeed) {
  const ImpedanceArm arm;
  Joints joints;
  for (int round = 0; round < 500; ++round) {
    const dvec3 q = joints.next().arm, speed = joints.vector(2.0), force = joints.vector(3.0);
    const double atJoints = glm::dot(arm.torqueOf(q, force), speed);
    EXPECT_NEAR(atJoints, glm::dot(force, arm.jacobian(q) * speed), 1e-12);
    EXPECT_LT(glm::distance(arm.forceOf(q, arm.torqueOf(q, force)), force), 1e-9);
  }
}

TEST(ImpedanceArm, JointRangesKeepItAwayFromBothSingularities) {
  const ImpedanceArm arm;
  double least = 1.0;
  for (double lift = 0.0; lift <= 1.75; lift += 0.01)
    for (double bend = -0.81; bend <= 1.25; bend += 0.01)
      least = std::min(least, arm.manipulability(arm.withinRange({0.0, lift, lift + bend})));
  EXPECT_GT(least, 0.04);
}

TEST(ImpedanceArm, BeyondItsRangesForcesStayBoundedAndOnlyTheBlockedDirectionIsLost) {
  const ImpedanceArm arm;
  const double right = std::numbers::pi / 2;
  const dvec3 stretched{0.0, 0.3, 0.3 + right};  // both links in one line
  EXPECT_NEAR(arm.manipulability(stretched), 0.0, 1e-15);
  const dvec3 along{0.0, std::sin(0.3), std::cos(0.3)}, across{0.0, std::cos(0.3), -std::sin(0.3)};
  EXPECT_LT(glm::length(arm.forceOf(stretched, arm.torqueOf(stretched, along))), 1e-9);
  EXPECT_GT(glm::dot(arm.forceOf(stretched, arm.torqueOf(stretched, across)), across), 0.99);
  for (double away = 1e-6; away < 0.2; away *= 1.5) {
    const dvec3 torque{0.1, 0.1, 0.1};
    EXPECT_LT(glm::length(arm.forceOf(stretched - dvec3(0.0, 0.0, away), torque)), 200.0);
  }
}

TEST(ImpedanceArm, GivesItsFullForceInEveryDirectionAtTheNominalPose) {
  const ImpedanceArm arm;
  const dvec3 nominal = arm.parameters().nominal;
  Joints joints;
  for (int round = 0; round < 300; ++round) {
    const dvec3 direction = glm::normalize(joints.vector(1.0));
    dvec3 heat(0.0);
    const ArmCommand command = arm.command(nominal, 3.29 * direction, heat, 1e-3);
    EXPECT_FALSE(command.saturated);
    EXPECT_LT(glm::distance(command.force, 3.29 * direction), 1e-9);
    for (int i = 0; i < 3; ++i) {
      EXPECT_NEAR(command.current[i] * 10.0 * 0.0234, command.torque[i], 1e-12);
      EXPECT_LE(std::abs(command.current[i]), 2.7 + 1e-12);
    }
  }
}

TEST(ImpedanceArm, ShortensAForceItCannotGiveWithoutTurningIt) {
  const ImpedanceArm arm;
  Joints joints;
  int shortened = 0;
  for (int round = 0; round < 500; ++round) {
    const dvec3 q = joints.next().arm, wanted = joints.vector(20.0);
    dvec3 heat(0.0);
    const ArmCommand command = arm.command(q, wanted, heat, 1e-3);
    EXPECT_LE(glm::length(command.force), 3.3 * (1.0 + 1e-9));
    EXPECT_LT(glm::length(glm::cross(command.force, glm::normalize(wanted))), 1e-8);
    EXPECT_GE(glm::dot(command.force, wanted), 0.0);
    shortened += command.saturated;
    for (int i = 0; i < 3; ++i) EXPECT_LE(std::abs(command.current[i]), 2.7 * (1.0 + 1e-12));
  }
  EXPECT_GT(shortened, 450);
  dvec3 heat(0.0);
  const ArmCommand none = arm.command({}, dvec3(std::numeric_limits<double>::quiet_NaN()), heat, 1e-3);
  EXPECT_LT(glm::length(none.force), 1e-12);
}

TEST(ImpedanceArm, AHotMotorFallsBackToWhatItCanHoldWithoutAStep) {
  const ImpedanceArm arm;
  const dvec3 q = arm.parameters().nominal;
  dvec3 heat(0.0);
  double last = 3.3, largestStep = 0.0;
  for (int tick = 0; tick < 60000; ++tick) {
    const double now = glm::length(arm.command(q, {3.3, 0.0, 0.0}, heat, 1e-3).force);
    largestStep = std::max(largestStep, std::abs(now - last));
    last = now;
    if (tick == 500) {
      EXPECT_NEAR(now, 3.3, 1e-9);
    }
  }
  EXPECT_NEAR(last, 0.88, 0.05);  // the data sheet's continuous force
  EXPECT_LT(largestStep, 0.02);
  for (int i = 0; i < 3; ++i) EXPECT_LE(std::sqrt(heat[i]), 0.72 * (1.0 + 1e-6));
}

TEST(ImpedanceArm, GravityTorqueIsTheSlopeOfThePotential) {
  const ImpedanceArm arm;
  const auto potential = [](const dvec3& q) {
    const double upper = 0.5 * 0.135 * std::sin(q.y);
    const double fore = 0.135 * std::sin(q.y) - 0.5 * 0.135 * std::cos(q.z);
    return 9.81 * 0.035 * (upper + fore);
  };
  Joints joints;
  for (int round = 0; round < 100; ++round) {
    const dvec3 q = joints.next().arm;
    for (int i = 0; i < 3; ++i) {
      dvec3 up = q, down = q;
      up[i] += 1e-5;
      down[i] -= 1e-5;
      EXPECT_NEAR(arm.gravityTorque(q)[i], -(potential(up) - potential(down)) / 2e-5, 1e-9);
    }
  }
}

TEST(ImpedanceArm, CompensatesItsWeightOnlyWhenAsked) {
  ImpedanceArmParameters parameters;
  dvec3 heat(0.0);
  const dvec3 q = parameters.nominal;
  EXPECT_LT(glm::length(ImpedanceArm(parameters).command(q, dvec3(0.0), heat, 1e-3).force), 1e-12);
  parameters.compensateGravity = false;
  const ImpedanceArm arm(parameters);
  const dvec3 weight = arm.command(q, dvec3(0.0), heat, 1e-3).force;
  EXPECT_LT(weight.y, -0.1);
  EXPECT_LT(glm::distance(arm.torqueOf(q, weight), arm.gravityTorque(q)), 1e-12);
}

TEST(ImpedanceArm, EncodersResolveAboutTheDataSheetsDistanceAtTheTip) {
  const ImpedanceArm arm;
  const double count = 2.0 * std::numbers::pi / arm.parameters().countsPerTurn;
  EXPECT_NEAR(count * arm.parameters().upperArm, 0.055e-3, 1e-7);
  Joints joints;
  double worst = 0.0;
  for (int round = 0; round < 1000; ++round) {
    const ArmJoints q = joints.next(), read = arm.encoded(q);
    for (int i = 0; i < 3; ++i) {
      EXPECT_LE(std::abs(read.arm[i] - q.arm[i]), 0.5 * count * (1.0 + 1e-9));
      EXPECT_NEAR(std::remainder(read.arm[i], count), 0.0, 1e-12);
    }
    worst = std::max(worst, glm::distance(arm.tip(read).position, arm.tip(q).position));
  }
  // Half a count at each joint, at most the sum of the lever arms.
  EXPECT_LE(worst, 0.5 * count * (0.27 + 2 * 0.135));
  EXPECT_GT(worst, 0.02e-3);
}

// --- the arm in a hand

HandTarget aim(const dvec3& position) {
  HandTarget target;
  target.worldFromTarget.position = position;
  return target;
}

/// Pushes 20 mm into a wall of stiffness K (x <= 0 is free) for two seconds and tells the unrest of the last
/// one: the largest less the smallest x, m.
double unrestAtWall(double stiffness, SimulatedArm& device) {
  device.setTarget(aim({0.02, 0.0, 0.0}));
  double low = 1e9, high = -1e9;
  for (int tick = 0; tick < 2000; ++tick) {
    const DeviceSample sample = device.poll(1e-3 * (tick + 1));
    const double depth = std::max(0.0, sample.worldFromDevice.position.x);
    Wrench wrench;
    wrench.force.x = -stiffness * depth;
    device.apply(wrench);
    if (tick < 1000) continue;
    low = std::min(low, device.hand().devicePose().position.x);
    high = std::max(high, device.hand().devicePose().position.x);
  }
  return high - low;
}

TEST(SimulatedArm, RestsAtAWallAndDoesNotAtOneTooStiffForItsDamping) {
  // Well damped, so that the person has come to rest and what still moves is the loop.
  const ArmParameters steady{
      .mass = 0.5, .stiffness = 300.0, .damping = 20.0, .gripStiffness = 800.0, .gripDamping = 10.0};
  SimulatedArm soft({}, {}, steady);
  EXPECT_LT(unrestAtWall(0.8 * stiffestStable(0.1, 1e-3, 0.0, 0.0), soft), 1e-4);
  EXPECT_NEAR(soft.command().force.x, -0.16 * 1e3 * soft.hand().devicePose().position.x, 0.02);
  SimulatedArm stiff({}, {}, steady);
  EXPECT_GT(unrestAtWall(1e5, stiff), 2e-4);  // the control: the same measure sees unrest
}

TEST(SimulatedArm, ReadsItsTipThroughTheEncoders) {
  SimulatedArm device;
  device.setTarget(aim({0.03, 0.02, -0.01}));
  double worst = 0.0;
  for (int tick = 0; tick < 1500; ++tick) {
    const DeviceSample sample = device.poll(1e-3 * (tick + 1));
    device.apply({});
    ASSERT_TRUE(sample.valid);
    worst =
        std::max(worst, glm::distance(sample.worldFromDevice.position, device.hand().devicePose().position));
  }
  EXPECT_GT(worst, 1e-6);
  EXPECT_LT(worst, 0.1e-3);
  EXPECT_LT(glm::distance(device.hand().devicePose().position, dvec3(0.03, 0.02, -0.01)), 2e-3);
}

TEST(SimulatedArm, StopsAtTheEndOfItsReachHoweverFarThePersonAims) {
  for (const dvec3& far :
       {dvec3(2.0, 0.0, 0.0), dvec3(0.0, 3.0, 1.0), dvec3(0.0, 0.0, -5.0), dvec3(-1.0, -1.0, 4.0)}) {
    SimulatedArm device;
    device.setTarget(aim(far));
    for (int tick = 0; tick < 1000; ++tick) {
      const DeviceSample sample = device.poll(1e-3 * (tick + 1));
      device.apply({});
      ASSERT_TRUE(sample.valid);
      const dvec3 q = device.joints().arm;
      ASSERT_LT(glm::distance(device.arm().withinRange(q), q), 1e-12);
      const dvec3 tip = transformPoint(device.worldFromBase(), device.arm().tip(device.joints()).position);
      ASSERT_LT(glm::distance(device.hand().devicePose().position, tip), 1e-9);
    }
    EXPECT_LT(glm::length(device.hand().deviceVelocity()), 0.05);
  }
}

TEST(SimulatedArm, CanBeChosenByName) {
  const auto device = openDevice("simulated-arm", Pose{{0.1, 0.2, 0.3}, {1.0, 0.0, 0.0, 0.0}});
  ASSERT_TRUE(device.ok());
  EXPECT_EQ((*device)->name(), "simulated-arm");
  const DeviceSample sample = (*device)->poll(0.0);
  EXPECT_LT(glm::distance(sample.worldFromDevice.position, dvec3(0.1, 0.2, 0.3)), 1e-4);
  EXPECT_NEAR((*device)->limits().quantum, 0.055e-3, 1e-7);
}

}  // namespace
}  // namespace tandem::haptics
