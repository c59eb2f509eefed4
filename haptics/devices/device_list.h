#pragma once

// Lists the devices, the driver of each, and why one cannot be opened. Not for the servo thread.

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "haptics/base/device.h"
#include "haptics/devices/colocation.h"
#include "haptics/devices/hid_transport.h"

namespace tandem::haptics {

struct DeviceReport {
  std::string name;
  std::uint16_t vendor = 0, product = 0;  // 0 for devices without hardware
  std::string node;                       // empty for devices without hardware
  std::string driver;                     // the name for openDevice()
  bool usable = false;
  std::string reason;               // why it is not usable, one line
  std::vector<std::string> remedy;  // shell commands that fix it
};

/// Whether a node can be opened for reading and writing, and by whom.
struct NodeAccess {
  int error = 0;  // errno of the attempt
  unsigned mode = 0;
  std::string owner, group;
};
NodeAccess checkNode(const std::string& path);

/// Fills usable, reason and remedy of a report from the result of checkNode().
void explainAccess(const NodeAccess& access, DeviceReport& report);

/// The built-in devices, then the hardware on the bus with a known driver.
std::vector<DeviceReport> listDevices(HidBus& bus);
std::vector<DeviceReport> listDevices();

/// Creates and opens a device by the driver name from listDevices(), starting at a pose.
///
/// A device with a workspace of its own (`haply`, `pid`, `simulated-arm`) is placed by its calibration if
/// there is one; otherwise its first reading becomes the start if that is given; otherwise its readings are
/// in its own axes. The other devices take no calibration. HID devices are searched on `bus`.
Result<std::unique_ptr<Device>> openDevice(const std::string& name,
                                           const std::optional<Pose>& worldFromStart = std::nullopt,
                                           const Colocation* calibration = nullptr,
                                           HidBus& bus = systemHidBus());

/// Progress of a self-test.
struct DeviceTestState {
  DeviceSample sample;
  double elapsed = 0.0;       // s
  std::uint64_t ticks = 0;    // readings taken
  std::uint64_t valid = 0;    // of them valid
  std::uint64_t changes = 0;  // of them different from the one before
  double tickRate = 0.0;      // Hz
};

/// Reads an open device at 1 kHz under zero force for some seconds, with a callback about 20 times a second
/// in the calling thread. Ends early when the callback returns false. Returns the last state.
DeviceTestState testDevice(Device& device, double seconds,
                           const std::function<bool(const DeviceTestState&)>& callback);

}  // namespace tandem::haptics
