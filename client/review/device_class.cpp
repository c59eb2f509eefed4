#include "client/review/device_class.h"

#include <iterator>

namespace tandem::client {
namespace {

/// Figures of published data sheets and measurements. Physical damping and quantum limit the stable
/// stiffness.
const DeviceClass kDevices[] = {
    {"desktop",
     "desktop arm of the Phantom Omni class",
     {6, 3, 3.3, 0.0, 0.045, 0.1, 0.055e-3, 0.08, 1000.0}},
    {"damped", "the same arm held by a firm hand", {6, 3, 3.3, 0.0, 0.045, 1.0, 0.055e-3, 0.08, 1000.0}},
    {"sixdof",
     "a model of a six-axis arm: force, mass and quantum of the Phantom Premium 6DOF class, damping and "
     "inertia assumed",
     {6, 6, 8.5, 0.17, 0.136, 0.3, 0.03e-3, 0.15, 1000.0, 1e-4, 1e-3}},
    {"stylus", "mouse and keyboard", {6, 3, 3.3, 0.0, 0.045, 0.1, 0.055e-3, 0.2, 1000.0}},
};

}  // namespace

const DeviceClass* findDeviceClass(const std::string& name) {
  for (const DeviceClass& entry : kDevices) {
    if (name == entry.name) return &entry;
  }
  return nullptr;
}

std::string deviceClassNames() {
  std::string names;
  const std::size_t count = std::size(kDevices);
  for (std::size_t i = 0; i < count; ++i) {
    if (i > 0) names += i + 1 < count ? ", " : " or ";
    names += kDevices[i].name;
  }
  return names;
}

}  // namespace tandem::client
