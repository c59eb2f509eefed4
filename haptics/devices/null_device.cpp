#include "haptics/devices/null_device.h"

namespace tandem::haptics {

DeviceLimits NullDevice::limits() const {
  DeviceLimits limits;
  limits.sensedAxes = 0;
  limits.workspaceRadius = 0.0;
  limits.rate = 0.0;
  return limits;
}

DeviceSample NullDevice::poll(double now) {
  DeviceSample sample;
  sample.time = now;
  return sample;
}

}  // namespace tandem::haptics
