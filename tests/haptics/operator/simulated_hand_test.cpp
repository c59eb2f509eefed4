#include "haptics/operator/simulated_hand.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>

#include "haptics/devices/null_device.h"
#include "haptics/devices/simulated_device.h"

namespace tandem::haptics {
namespace {

constexpr double kTick = 1e-3;
const glm::dvec3 kNoForce{0.0, 0.0, 0.0};

SimulatedDeviceParameters frictionless() {
  SimulatedDeviceParameters device;
  device.friction = 0.0;
  return device;
}

HandTarget at(const glm::dvec3& position, bool holds = true) {
  HandTarget target;
  target.worldFromTarget.position = position;
  target.holdsStylus = holds;
  return target;
}

TEST(SimulatedHand, ArmThatHoldsNothingOscillatesAsTheDampedOscillator) {
  const ArmParameters arm;
  SimulatedHand hand(arm, frictionless(), Pose{});
  const double decay = arm.damping / (2.0 * arm.mass);
  const double omega = std::sqrt(arm.stiffness / arm.mass - decay * decay);
  for (int i = 1; i <= 2000; ++i) {
    hand.step(at({0.01, 0.0, 0.0}, false), kNoForce, kTick);
    const double t = i * kTick;
    const double exact =
        0.01 * (1.0 - std::exp(-decay * t) * (std::cos(omega * t) + decay / omega * std::sin(omega * t)));
    ASSERT_NEAR(hand.armPose().position.x, exact, 1e-5) << "at " << t;
  }
  EXPECT_EQ(hand.devicePose().position.x, 0.0) << "a stylus that nobody holds must stay";
}

TEST(SimulatedHand, FreeDeviceReachesTheSpeedOfForceOverDamping) {
  const SimulatedDeviceParameters device = frictionless();
  SimulatedHand hand({}, device, Pose{});
  for (int i = 1; i <= 1000; ++i) {
    hand.step(at(kNoForce, false), {0.0, 0.02, 0.0}, kTick);
    const double exact = 0.02 / device.damping * (1.0 - std::exp(-device.damping * i * kTick / device.mass));
    ASSERT_NEAR(hand.deviceVelocity().y, exact, 2e-4);
  }
}

TEST(SimulatedHand, YieldsToASteadyForceByArmAndGripInSeries) {
  const ArmParameters arm;
  SimulatedHand hand(arm, frictionless(), Pose{});
  for (int i = 0; i < 8000; ++i) hand.step(at(kNoForce), {0.0, 0.0, 1.0}, kTick);
  EXPECT_NEAR(hand.devicePose().position.z, 1.0 / arm.stiffness + 1.0 / arm.gripStiffness, 1e-6);
  EXPECT_NEAR(hand.armPose().position.z, 1.0 / arm.stiffness, 1e-6);
}

TEST(SimulatedHand, FollowsAMovingTargetWhoseVelocityAndAccelerationItKnows) {
  SimulatedHand hand({}, {}, Pose{});
  double worst = 0.0;
  for (int i = 0; i < 3000; ++i) {
    const double w = 2.0 * std::numbers::pi * 0.5, t = i * kTick;
    HandTarget target = at({0.05 * std::sin(w * t), 0.0, 0.0});
    target.velocity.x = 0.05 * w * std::cos(w * t);
    target.acceleration.x = -0.05 * w * w * std::sin(w * t);
    hand.step(target, kNoForce, kTick);
    if (t > 1.5)
      worst = std::max(worst, std::abs(hand.armPose().position.x - target.worldFromTarget.position.x));
  }
  EXPECT_LT(worst, 2.5e-3);  // friction and the device's own mass pull it back
}

TEST(SimulatedHand, EnergyGivenIsTheIntegralOfForceTimesTravel) {
  SimulatedHand hand({}, {}, Pose{});
  double expected = 0.0;
  for (int i = 0; i < 1000; ++i) {
    const glm::dvec3 force{std::sin(0.03 * i), 0.5 * std::cos(0.02 * i), -0.3};
    const glm::dvec3 before = hand.devicePose().position;
    hand.step(at({0.02, 0.01, 0.0}), force, kTick);
    expected += glm::dot(force, hand.devicePose().position - before);
  }
  EXPECT_NEAR(hand.energyGiven(), expected, 1e-12);
  EXPECT_GT(std::abs(expected), 1e-3);
}

TEST(SimulatedHand, ReadsMultiplesOfTheQuantumWithinHalfOfIt) {
  const SimulatedDeviceParameters device;
  SimulatedHand hand({}, device, Pose{});
  for (int i = 0; i < 500; ++i) {
    hand.step(at({0.03, -0.02, 0.01}), kNoForce, kTick);
    const DeviceSample sample = hand.sample(i * kTick);
    for (int axis = 0; axis < 3; ++axis) {
      const double reading = sample.worldFromDevice.position[axis] / device.quantum;
      ASSERT_NEAR(reading, std::round(reading), 1e-9);
      ASSERT_LE(std::abs(sample.worldFromDevice.position[axis] - hand.devicePose().position[axis]),
                0.5 * device.quantum + 1e-12);
    }
    ASSERT_TRUE(sample.valid);
  }
}

TEST(SimulatedHand, EstimatesVelocityFromItsReadings) {
  SimulatedHand hand({}, frictionless(), Pose{});
  for (int i = 0; i < 5000; ++i) {
    HandTarget target = at({0.1 * i * kTick, 0.0, 0.0});
    target.velocity.x = 0.1;
    hand.step(target, kNoForce, kTick);
  }
  EXPECT_NEAR(hand.sample(1.0).twist.linear.x, hand.deviceVelocity().x, 0.02);
  EXPECT_NEAR(hand.deviceVelocity().x, 0.1, 0.01);
}

TEST(SimulatedHand, TurnsTowardsItsTargetAndReportsTheTurnRate) {
  SimulatedHand hand({}, {}, Pose{});
  HandTarget target = at(kNoForce);
  target.worldFromTarget.orientation = fromRotationVector({0.0, 1.0, 0.0});
  hand.step(target, kNoForce, kTick);
  EXPECT_NEAR(hand.sample(0.0).twist.angular.y, 1.0 / 0.05, 0.5);
  for (int i = 0; i < 1000; ++i) hand.step(target, kNoForce, kTick);
  EXPECT_NEAR(rotationVector(hand.devicePose().orientation).y, 1.0, 1e-6);
}

TEST(SimulatedHand, ForceIsLimitedAndNotANumberCountsAsZero) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  SimulatedHand pushed({}, {}, Pose{}), limit({}, {}, Pose{}), lost({}, {}, Pose{}), free({}, {}, Pose{});
  for (int i = 0; i < 100; ++i) {
    pushed.step(at(kNoForce), {1e9, 0.0, 0.0}, kTick);
    limit.step(at(kNoForce), {3.3, 0.0, 0.0}, kTick);
    lost.step(at(kNoForce), {nan, 1.0, 0.0}, kTick);
    free.step(at(kNoForce), kNoForce, kTick);
  }
  EXPECT_NEAR(pushed.devicePose().position.x, limit.devicePose().position.x, 1e-12);
  EXPECT_EQ(lost.devicePose().position, free.devicePose().position);
}

/// Greatest distance from the middle of a spring rendered to a stylus that nobody holds, in the last of
/// `ticks` ticks, having started 10 mm away.
double swingOnSpring(double stiffness, int ticks) {
  SimulatedDeviceParameters device;
  device.forceMax = 1e6;
  SimulatedHand hand({}, device, Pose{{0.01, 0.0, 0.0}, glm::dquat(1.0, 0.0, 0.0, 0.0)});
  double swing = 0.0;
  for (int i = 0; i < ticks; ++i) {
    const glm::dvec3 force = -stiffness * hand.sample(0.0).worldFromDevice.position;
    hand.step(at(kNoForce, false), force, kTick);
    if (i > ticks / 2) swing = std::max(swing, std::abs(hand.devicePose().position.x));
  }
  return swing;
}

TEST(SimulatedHand, ASpringBelowTwiceDampingOverPeriodSettles) {
  const double limit = 2.0 * SimulatedDeviceParameters{}.damping / kTick;  // 200 N/m
  EXPECT_LT(swingOnSpring(0.75 * limit, 6000), 1e-3);
}

TEST(SimulatedHand, ASpringFarAboveTwiceDampingOverPeriodDiverges) {
  const double limit = 2.0 * SimulatedDeviceParameters{}.damping / kTick;
  EXPECT_GT(swingOnSpring(10.0 * limit, 2000), 0.1);
}

TEST(SimulatedDevice, MovesUnderItsTargetAndForceAtTheRateOfPolls) {
  SimulatedDevice device;
  ASSERT_TRUE(device.open().ok());
  device.setTarget(at({0.02, 0.0, 0.0}));
  device.setButtons(1);
  DeviceSample sample;
  SimulatedHand alone({}, {}, Pose{});
  for (int i = 0; i <= 1000; ++i) {
    sample = device.poll(100.0 + i * kTick);
    device.apply({{0.0, 0.1, 0.0}, {}});
    if (i > 0) alone.step(at({0.02, 0.0, 0.0}), {0.0, 0.1, 0.0}, kTick);
  }
  EXPECT_TRUE(sample.valid);
  EXPECT_EQ(sample.buttons, 1u);
  EXPECT_NEAR(sample.worldFromDevice.position.x, alone.devicePose().position.x, 1e-4);
  EXPECT_NEAR(sample.worldFromDevice.position.y, alone.devicePose().position.y, 1e-4);
}

TEST(SimulatedDevice, LetsGoOfAForceThatIsNotRenewed) {
  SimulatedDevice device;
  ASSERT_TRUE(device.open().ok());
  device.poll(0.0);
  device.apply({{3.0, 0.0, 0.0}, {}});
  for (int i = 1; i <= 5000; ++i) device.poll(i * kTick);
  EXPECT_LT(std::abs(device.hand().devicePose().position.x), 2e-3) << "3 N held would be 70 mm";
}

TEST(SimulatedDevice, IgnoresATargetThatIsNotANumber) {
  SimulatedDevice device;
  ASSERT_TRUE(device.open().ok());
  device.setTarget(at({std::numeric_limits<double>::quiet_NaN(), 0.0, 0.0}));
  HandTarget fast = at(kNoForce);
  fast.velocity.y = std::numeric_limits<double>::infinity();
  device.setTarget(fast);
  for (int i = 0; i < 100; ++i) EXPECT_TRUE(device.poll(i * kTick).valid);
  EXPECT_EQ(device.hand().devicePose().position, kNoForce);
}

TEST(SimulatedDevice, AClockThatLeapsDoesNotMakeTheHandLeap) {
  EXPECT_EQ(pollInterval(1.0, 1.001), 1.001 - 1.0);
  EXPECT_EQ(pollInterval(1.0, 0.5), 0.0);
  EXPECT_EQ(pollInterval(1.0, std::numeric_limits<double>::quiet_NaN()), 0.0);
  EXPECT_EQ(pollInterval(1.0, 1e6), 0.02);
}

TEST(NullDevice, HasNoHandAndNoForce) {
  NullDevice device;
  ASSERT_TRUE(device.open().ok());
  EXPECT_FALSE(device.poll(1.0).valid);
  EXPECT_EQ(device.limits().maxForce, 0.0);
  device.apply({{1.0, 0.0, 0.0}, {}});
  device.close();
}

}  // namespace
}  // namespace tandem::haptics
