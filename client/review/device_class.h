#pragma once

// Classes of haptic devices, for predictions where no device is connected.

#include <string>

#include "haptics/base/device.h"

namespace tandem::client {

struct DeviceClass {
  const char* name;
  const char* what;
  haptics::DeviceLimits limits;
};

/// Null if there is none of this name.
const DeviceClass* findDeviceClass(const std::string& name);

/// All names, for help and errors: "a, b or c".
std::string deviceClassNames();

}  // namespace tandem::client
