#pragma once

// A haptic device: senses the pose of a hand, applies a wrench to it. One back-end a file in
// haptics/devices/.
//
// Threads: open() and close() anywhere but in the servo thread; poll() and apply() only in the servo
// thread. Both return at once: a driver whose bus blocks keeps a thread of its own and hands over the
// latest sample.

#include <cstdint>
#include <string>

#include "assets/base/pose.h"
#include "assets/base/result.h"

namespace tandem::haptics {

/// One reading of a device, already in world axes (see DeviceMapping for how a workspace is placed in the
/// scene).
struct DeviceSample {
  Pose worldFromDevice;
  Twist twist;                // estimated by the driver from its own samples
  std::uint32_t buttons = 0;  // bit i = button i; button 0 grasps, button 1 is the clutch
  double time = 0.0;          // s, the servo loop's clock, when the reading was taken
  bool valid = false;         // false: lost, stale or not finite; the tick answers with zero force
};

/// What a device can do, SI. Zero maxForce: input only.
struct DeviceLimits {
  int sensedAxes = 3;            // 3 or 6
  int actuatedAxes = 0;          // 0, 3 or 6
  double maxForce = 0.0;         // N
  double maxTorque = 0.0;        // N·m
  double mass = 0.0;             // kg, apparent at the tip
  double damping = 0.0;          // N·s/m, physical
  double quantum = 0.0;          // m, of the position reading
  double workspaceRadius = 0.1;  // m
  double rate = 1000.0;          // Hz at which poll() has something new
  double inertia = 0.0;          // kg·m^2, apparent about the tip
  double rotDamping = 0.0;       // N·m·s/rad, physical, about the tip
};

class Device {
 public:
  virtual ~Device() = default;
  virtual std::string name() const = 0;
  virtual DeviceLimits limits() const = 0;
  virtual Status open() = 0;
  virtual void close() = 0;
  /// The latest reading. `now` is the servo loop's clock in s.
  virtual DeviceSample poll(double now) = 0;
  /// The wrench on the hand, world axes, already limited to limits(). Must be called every tick; without a
  /// call for 50 ms a driver sends zero by itself.
  virtual void apply(const Wrench& toHand) = 0;
};

}  // namespace tandem::haptics
