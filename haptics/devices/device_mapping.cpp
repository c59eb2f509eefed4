#include "haptics/devices/device_mapping.h"

#include "assets/base/assert.h"

namespace tandem::haptics {
namespace {

constexpr std::uint32_t kClutch = 1u << 1;

}  // namespace

DeviceMapping::DeviceMapping(const Pose& worldFromBase, double scale)
    : worldFromBase_(worldFromBase), scale_(scale) {
  ASSERT(scale > 0.0 && isValid(worldFromBase));
}

glm::dvec3 DeviceMapping::unshifted(const glm::dvec3& devicePosition) const {
  return transformPoint(worldFromBase_, scale_ * devicePosition);
}

DeviceSample DeviceMapping::toWorld(const DeviceSample& device) {
  if (!device.valid) return device;
  DeviceSample world = device;
  const glm::dvec3 base = unshifted(device.worldFromDevice.position);
  world.worldFromDevice.orientation =
      glm::normalize(worldFromBase_.orientation * device.worldFromDevice.orientation);
  world.twist = {worldFromBase_.orientation * (scale_ * device.twist.linear),
                 worldFromBase_.orientation * device.twist.angular};
  const bool clutch = (device.buttons & kClutch) != 0;
  if (started_ && (clutch || clutched_)) shift_ = last_ - base;
  clutched_ = clutch;
  started_ = true;
  last_ = base + shift_;
  world.worldFromDevice.position = last_;
  if (clutch) world.twist.linear = glm::dvec3{0.0, 0.0, 0.0};
  return world;
}

Wrench DeviceMapping::toDevice(const Wrench& world) const {
  const glm::dquat baseFromWorld = glm::conjugate(worldFromBase_.orientation);
  return {baseFromWorld * world.force, baseFromWorld * world.torque / scale_};
}

void DeviceMapping::recentre(const DeviceSample& device, const glm::dvec3& world) {
  if (!device.valid) return;
  shift_ = world - unshifted(device.worldFromDevice.position);
  last_ = world;
}

DeviceLimits DeviceMapping::inWorld(const DeviceLimits& device) const {
  ASSERT(scale_ > 0.0);
  DeviceLimits world = device;
  world.quantum *= scale_;
  world.workspaceRadius *= scale_;
  world.mass /= scale_;
  world.damping /= scale_;
  world.maxTorque *= scale_;
  world.inertia *= scale_;
  world.rotDamping *= scale_;
  return world;
}

}  // namespace tandem::haptics
