#pragma once

// A force-feedback joystick or wheel of the USB PID class. The stick is a hand on a horizontal plane: right
// is x, back is z; forces along these go to the motors as one constant force per axis.
//
// 1. A separate thread reads axes and sends forces: on change, at most every millisecond, and zero after 50
//    ms without a call of apply(). The device's USB interval, 1 to 10 ms, decides how often a force arrives.
// 2. The class uses fractions of full force instead of newtons; `maxForce` states full force.
// 3. Samples of an unplugged device are invalid; it is set up again when it returns.
// 4. The device itself can run damping against the vibration of such a slow loop (`damper`).
//
// Threads: poll() and apply() from the servo thread.

#include <memory>

#include "haptics/base/device.h"
#include "haptics/devices/hid_transport.h"

namespace tandem::haptics {

struct PidSettings {
  double reach = 0.05;                    // m from the middle to the end of an axis
  double maxForce = 3.0;                  // N at full force; a device does not state it
  double damper = 0.0;                    // 0..1: a damper that the device runs on each axis; 0: none
  bool invertX = false, invertY = false;  // the sign of the motors, which differs between firmwares
};

/// Latest state of the driver's thread.
struct PidReading {
  double axes[2] = {0.0, 0.0};  // -1..1
  std::uint32_t buttons = 0;
  std::uint64_t reports = 0, rejected = 0;  // read
  std::uint64_t written = 0;                // forces sent
  double writeTime = 0.0;                   // s: duration of the last write, including the device's interval
  bool connected = false;
};

/// Whether an interface may be a force-feedback device: a joystick, gamepad or multi-axis controller without
/// another driver. Its descriptor decides.
bool mayBePid(const HidInfo& info);

/// Checks whether the descriptor of an interface has what a constant force needs; the error is the reason if
/// not.
Status checkPid(HidBus& bus, const HidInfo& info);

class PidDevice : public Device {
 public:
  explicit PidDevice(HidBus& bus, const Pose& worldFromStart = {}, const PidSettings& settings = {});
  ~PidDevice() override;  // closes

  std::string name() const override { return "pid"; }
  /// The number of actuated axes is that of the device's motors, once open.
  DeviceLimits limits() const override;
  Status open() override;
  void close() override;
  DeviceSample poll(double now) override;
  void apply(const Wrench& toHand) override;

  /// The latest reading; servo thread.
  const PidReading& reading() const;

 private:
  struct Driver;
  Pose worldFromStart_;
  PidSettings settings_;
  std::unique_ptr<Driver> driver_;
  double position_[2] = {0.0, 0.0}, speed_[2] = {0.0, 0.0};
  double lastPoll_ = 0.0;
  bool started_ = false;
};

}  // namespace tandem::haptics
