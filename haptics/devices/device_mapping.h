#pragma once

// Places a device's workspace in the scene: turn, scale, shift; and the clutch (button 1), which lifts the
// device off the scene so that a small workspace reaches all of a large one. Pure, no clock; one thread.
//
// 1. Taking or leaving the clutch never moves the world pose: no force step.
// 2. Forces pass unscaled, turned only: seen from the hand, stiffness is scaled by `scale`. Torques are divided by it, as
//    the levers that make them are: so forces and torques give the hand the same share of the world's work, and what is
//    passive in the world is passive at the device. Device limits are scaled to match (see inWorld()).

#include "haptics/base/device.h"

namespace tandem::haptics {

class DeviceMapping {
 public:
  /// worldFromBase places the device's base; `scale` > 0 is world metres per device metre.
  explicit DeviceMapping(const Pose& worldFromBase = {}, double scale = 1.0);

  /// The reading in the world; frozen in position, at zero velocity, while the clutch is down. Not valid:
  /// passed on.
  DeviceSample toWorld(const DeviceSample& device);

  /// A wrench in world axes, in the device's base axes.
  Wrench toDevice(const Wrench& world) const;

  /// Shifts the workspace so that the device, where it is now, stands at `world`.
  void recentre(const DeviceSample& device, const glm::dvec3& world);

  /// The device's limits as the scene sees them: lengths times scale; mass and damping, at equal force,
  /// divided by it; torque, inertia and damping of turning, at equal angles, times scale.
  DeviceLimits inWorld(const DeviceLimits& device) const;

 private:
  glm::dvec3 unshifted(const glm::dvec3& devicePosition) const;

  Pose worldFromBase_;
  double scale_;
  glm::dvec3 shift_{0.0, 0.0, 0.0};  // world, from clutching and re-centring
  glm::dvec3 last_{0.0, 0.0, 0.0};   // world position given last
  bool clutched_ = false, started_ = false;
};

}  // namespace tandem::haptics
