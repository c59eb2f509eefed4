#include "haptics/devices/device_list.h"

#include <fcntl.h>
#include <grp.h>
#include <pwd.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <thread>

#include "haptics/base/triple_buffer.h"
#include "haptics/devices/dualsense.h"
#include "haptics/devices/haply_device.h"
#include "haptics/devices/null_device.h"
#include "haptics/devices/pid_device.h"
#include "haptics/devices/placed_device.h"
#include "haptics/devices/simulated_arm.h"
#include "haptics/devices/simulated_device.h"
#include "haptics/devices/spacemouse.h"
#include "haptics/devices/udev_rule.h"
#include "haptics/operator/virtual_stylus.h"
#include "haptics/servo/servo_loop.h"

namespace tandem::haptics {
namespace {

constexpr const char* kDeviceNames =
    "stylus, simulated, simulated-arm, none, spacemouse, dualsense, pid or haply";

DeviceReport builtIn(const char* name, const char* driver) {
  DeviceReport report;
  report.name = name;
  report.driver = driver;
  report.usable = true;
  return report;
}

bool sameReading(const DeviceSample& a, const DeviceSample& b) {
  return a.worldFromDevice.position == b.worldFromDevice.position &&
         a.worldFromDevice.orientation == b.worldFromDevice.orientation && a.buttons == b.buttons &&
         a.valid == b.valid;
}

/// The driver of an interface, if any.
struct Driver {
  const char* name = nullptr;
  std::string shown;
};

Driver driverOf(HidBus& bus, const HidInfo& info) {
  if (isSpaceMouse(info)) return {"spacemouse", spaceMouseName(info.vendor, info.product)};
  if (isDualSense(info)) return {"dualsense", dualSenseName(info.vendor, info.product)};
  if (mayBePid(info) && checkPid(bus, info).ok())
    return {"pid", info.productName.empty() ? "Force-feedback joystick" : info.productName};
  return {};
}

bool hasOwnWorkspace(const std::string& name) {
  return name == "simulated-arm" || name == "pid" || name.starts_with("haply");
}

/// Creates a device without opening it. Modelled hands begin at the start; the caller places devices with a
/// workspace.
Result<std::unique_ptr<Device>> makeDevice(const std::string& name, const Pose& start, bool calibrated,
                                           HidBus& bus) {
  using Made = std::unique_ptr<Device>;
  if (name == "stylus") return Made(std::make_unique<VirtualStylus>(start));
  if (name == "simulated") return Made(std::make_unique<SimulatedDevice>(start));
  if (name == "simulated-arm") return Made(std::make_unique<SimulatedArm>(calibrated ? Pose{} : start));
  if (name == "none") return Made(std::make_unique<NullDevice>());
  if (name == "spacemouse") return Made(std::make_unique<SpaceMouse>(bus, start));
  if (name == "dualsense") return Made(std::make_unique<DualSense>(bus, start));
  if (name == "pid") return Made(std::make_unique<PidDevice>(bus));
  if (name.starts_with("haply")) {
    Result<HaplySettings> settings = parseHaplyName(name);
    if (!settings) return settings.error();
    return Made(std::make_unique<HaplyDevice>(*settings));
  }
  return Error{"device '" + name + "' is not known: use " + std::string(kDeviceNames)};
}

DeviceReport haplyReport() {
  DeviceReport report = builtIn("Haply Inverse3 (through its local service)", "haply");
  const HaplySettings settings;
  report.node = settings.host + ":" + std::to_string(settings.port);
  const Status there = probeHaply(settings);
  report.usable = there.ok();
  if (!there) report.reason = there.error().message;
  return report;
}

}  // namespace

NodeAccess checkNode(const std::string& path) {
  NodeAccess access;
  struct stat status {};
  if (stat(path.c_str(), &status) == 0) {
    access.mode = status.st_mode & 07777;
    const passwd* user = getpwuid(status.st_uid);
    access.owner = user ? user->pw_name : std::to_string(status.st_uid);
    const group* members = getgrgid(status.st_gid);
    access.group = members ? members->gr_name : std::to_string(status.st_gid);
  }
  const int file = ::open(path.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);
  if (file < 0)
    access.error = errno;
  else
    ::close(file);
  return access;
}

void explainAccess(const NodeAccess& access, DeviceReport& report) {
  report.usable = access.error == 0;
  report.reason.clear();
  report.remedy.clear();
  if (report.usable) return;
  if (access.error == EACCES || access.error == EPERM) {
    char mode[8];
    std::snprintf(mode, sizeof mode, "%04o", access.mode);
    report.reason = "permission denied: " + report.node + " has mode " + mode + ", owner " + access.owner +
                    ":" + access.group + "; install the udev rule, then plug the device in again";
    report.remedy = {"tandem devices --udev-rule | sudo tee " + std::string(kUdevRulePath),
                     "sudo udevadm control --reload && sudo udevadm trigger --subsystem-match=hidraw"};
  } else if (access.error == EBUSY) {
    report.reason = report.node + " is busy: another program has it to itself (spacenavd, 3DxWare)";
    report.remedy = {"sudo fuser -v " + report.node};
  } else if (access.error == ENOENT || access.error == ENODEV || access.error == ENXIO ||
             access.error == EIO) {
    report.reason = report.node + " is gone: the device was unplugged";
  } else {
    report.reason = report.node + ": " + std::strerror(access.error);
  }
}

std::vector<DeviceReport> listDevices(HidBus& bus) {
  std::vector<DeviceReport> reports{builtIn("Virtual stylus (mouse and keyboard)", "stylus"),
                                    builtIn("Simulated hand (scripts and tests)", "simulated"),
                                    builtIn("Simulated desktop arm with joints and motors", "simulated-arm"),
                                    builtIn("No device (watch only)", "none"), haplyReport()};
  for (const HidInfo& info : bus.enumerate()) {
    const Driver driver = driverOf(bus, info);
    if (driver.name == nullptr) continue;
    DeviceReport report = builtIn(driver.shown.c_str(), driver.name);
    report.vendor = info.vendor;
    report.product = info.product;
    report.node = info.path;
    explainAccess(checkNode(info.path), report);
    reports.push_back(std::move(report));
  }
  return reports;
}

std::vector<DeviceReport> listDevices() { return listDevices(systemHidBus()); }

Result<std::unique_ptr<Device>> openDevice(const std::string& name, const std::optional<Pose>& worldFromStart,
                                           const Colocation* calibration, HidBus& bus) {
  Result<std::unique_ptr<Device>> made =
      makeDevice(name, worldFromStart.value_or(Pose{}), calibration != nullptr, bus);
  if (!made) return made;
  std::unique_ptr<Device> device = std::move(made).value();
  const bool absolute = hasOwnWorkspace(name);
  if (calibration != nullptr) {
    if (!absolute) return Error{"device '" + name + "' has no workspace of its own to be calibrated"};
    device = std::make_unique<PlacedDevice>(std::move(device), mappingOf(*calibration));
  } else if (absolute && worldFromStart && name != "simulated-arm") {
    device = std::make_unique<PlacedDevice>(
        std::move(device), DeviceMapping({{}, worldFromStart->orientation}), worldFromStart->position);
  }
  if (Status opened = device->open(); !opened) {
    std::string why = opened.error().message;
    for (const DeviceReport& report : listDevices())
      if (report.driver == name && !report.usable) why = name + ": " + report.reason;
    return Error{why};
  }
  return device;
}

DeviceTestState testDevice(Device& device, double seconds,
                           const std::function<bool(const DeviceTestState&)>& callback) {
  TripleBuffer<DeviceTestState> latest;
  DeviceTestState running;
  ServoLoop loop(device, [&](const DeviceSample& sample, double) {
    ++running.ticks;
    running.valid += sample.valid;
    if (running.ticks > 1) running.changes += !sameReading(sample, running.sample);
    running.sample = sample;
    latest.write(running);
    return Wrench{};
  });
  const double start = ServoLoop::now();
  DeviceTestState state;
  loop.start();
  do {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    state = latest.latest();
    state.elapsed = ServoLoop::now() - start;
    state.tickRate = static_cast<double>(state.ticks) / state.elapsed;
  } while (callback(state) && state.elapsed < seconds);
  loop.stop();
  return state;
}

}  // namespace tandem::haptics
