#include "haptics/devices/simulated_device.h"

namespace tandem::haptics {
namespace {

HandTarget targetAt(const Pose& pose) {
  HandTarget target;
  target.worldFromTarget = pose;
  return target;
}

}  // namespace

SimulatedDevice::SimulatedDevice(const Pose& worldFromStart, const ArmParameters& arm,
                                 const SimulatedDeviceParameters& device)
    : HandDevice(worldFromStart, arm, device, 0.15), target_(targetAt(worldFromStart)) {}

HandTarget SimulatedDevice::nextTarget(double) { return target_.latest(); }

void SimulatedDevice::setTarget(const HandTarget& target) {
  if (isValid(target)) target_.write(target);
}

}  // namespace tandem::haptics
