#include "haptics/devices/device_mapping.h"

#include <gtest/gtest.h>

#include <glm/geometric.hpp>
#include <numbers>

namespace tandem::haptics {
namespace {

DeviceSample at(const glm::dvec3& position, std::uint32_t buttons = 0) {
  DeviceSample sample;
  sample.worldFromDevice.position = position;
  sample.twist.linear = {0.1, 0.0, 0.0};
  sample.buttons = buttons;
  sample.valid = true;
  return sample;
}

void expectNear(const glm::dvec3& a, const glm::dvec3& b) { EXPECT_LT(glm::length(a - b), 1e-12); }

TEST(DeviceMapping, ScalesTurnsAndPlacesTheWorkspace) {
  const Pose base{{1.0, 0.0, 0.0}, fromRotationVector({0.0, 0.0, std::numbers::pi / 2})};
  DeviceMapping mapping(base, 10.0);
  const DeviceSample world = mapping.toWorld(at({0.01, 0.0, 0.0}));
  expectNear(world.worldFromDevice.position, {1.0, 0.1, 0.0});
  expectNear(world.twist.linear, {0.0, 1.0, 0.0});
  expectNear(mapping.toDevice({{0.0, 2.0, 0.0}, {0.0, 0.0, 1.0}}).force, {2.0, 0.0, 0.0});
}

TEST(DeviceMapping, ClutchHoldsTheWorldPoseAndNeverMakesItJump) {
  DeviceMapping mapping({}, 2.0);
  glm::dvec3 last = mapping.toWorld(at({0.0, 0.0, 0.0})).worldFromDevice.position;
  double deviceX = 0.0;
  for (int i = 1; i <= 400; ++i) {
    const bool clutch = (i / 50) % 2 == 1;
    deviceX += clutch ? -1e-3 : 1e-3;  // stroke forward, clutch back
    const DeviceSample world = mapping.toWorld(at({deviceX, 0.0, 0.0}, clutch ? 2 : 0));
    const double step = world.worldFromDevice.position.x - last.x;
    ASSERT_LT(step, 2.0 * 1e-3 + 1e-12);
    ASSERT_GE(step, -1e-12);
    if (clutch) {
      ASSERT_NEAR(step, 0.0, 1e-12);
      ASSERT_EQ(world.twist.linear.x, 0.0);
    }
    last = world.worldFromDevice.position;
  }
  EXPECT_GT(last.x, 0.35) << "the strokes add up while the device stays near its middle";
  EXPECT_LT(std::abs(deviceX), 0.06);
}

TEST(DeviceMapping, RecentresWithoutChangingTheDirection) {
  DeviceMapping mapping({}, 1.0);
  const DeviceSample here = at({0.05, 0.0, 0.0});
  mapping.recentre(here, {2.0, 3.0, 4.0});
  expectNear(mapping.toWorld(here).worldFromDevice.position, {2.0, 3.0, 4.0});
  expectNear(mapping.toWorld(at({0.06, 0.0, 0.0})).worldFromDevice.position, {2.01, 3.0, 4.0});
}

TEST(DeviceMapping, PassesALostReadingOnWithoutUsingIt) {
  DeviceMapping mapping;
  DeviceSample lost = at({1.0, 0.0, 0.0}, 2);
  lost.valid = false;
  EXPECT_FALSE(mapping.toWorld(lost).valid);
  expectNear(mapping.toWorld(at({0.0, 0.0, 0.0})).worldFromDevice.position, {0.0, 0.0, 0.0});
}

TEST(DeviceMapping, LimitsKeepTheStiffnessTheHandCanBear) {
  DeviceLimits device;
  device.damping = 0.1;
  device.quantum = 1e-4;
  const DeviceLimits world = DeviceMapping({}, 5.0).inWorld(device);
  EXPECT_DOUBLE_EQ(world.quantum, 5e-4);
  EXPECT_DOUBLE_EQ(world.damping, 0.02);
}

TEST(DeviceMapping, ForcesAndTorquesDoTheSameShareOfWork) {
  const double scale = 5.0;
  const Pose base{{1.0, 0.0, 0.0}, fromRotationVector({0.3, -0.2, 0.5})};
  DeviceMapping mapping(base, scale);
  const glm::dvec3 force{1.0, -2.0, 0.5}, arm{0.02, 0.01, -0.03}, way{1e-3, 2e-3, -1e-3},
      turn{0.01, 0.02, -0.03};
  const Wrench world{base.orientation * force, base.orientation * glm::cross(arm, force)};
  const Wrench device = mapping.toDevice(world);
  // A lever of the world is shorter by the scale at the device.
  expectNear(device.torque, glm::cross(arm / scale, force));
  const double byForce = glm::dot(device.force, way), byTorque = glm::dot(device.torque, turn);
  EXPECT_NEAR(glm::dot(world.force, base.orientation * (scale * way)), scale * byForce, 1e-15);
  EXPECT_NEAR(glm::dot(world.torque, base.orientation * turn), scale * byTorque, 1e-15);
  DeviceLimits limits;
  limits.maxTorque = 0.1, limits.inertia = 1e-4, limits.rotDamping = 1e-3;
  const DeviceLimits seen = mapping.inWorld(limits);
  EXPECT_DOUBLE_EQ(seen.maxTorque, 0.5);
  EXPECT_DOUBLE_EQ(seen.inertia, 5e-4);
  EXPECT_DOUBLE_EQ(seen.rotDamping, 5e-3);
}

}  // namespace
}  // namespace tandem::haptics
