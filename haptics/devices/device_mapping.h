#pragma once

// Places a device's workspace in the scene by rotation, scale and shift. The clutch (button 1) detaches the
// device from the scene, so that a small workspace reaches all of a large one. Pure, no clock; one thread.
//
// 1. Engaging or releasing the clutch never moves the world pose, so no force step occurs.
// 2. Forces are rotated but not scaled, so the hand feels a stiffness scaled by `scale`. Torques are divided
//    by `scale`, like the levers that make them. Forces and torques thus give the hand the same share of the
//    world's work, and what is passive in the world is passive at the device. Device limits are scaled to
//    match (see inWorld()).

#include "haptics/base/device.h"

namespace tandem::haptics {

class DeviceMapping {
 public:
  /// worldFromBase places the device's base; `scale` > 0 is world metres per device metre.
  explicit DeviceMapping(const Pose& worldFromBase = {}, double scale = 1.0);

  /// The reading in the world; while the clutch is down its position is frozen and its velocity zero. An
  /// invalid reading passes unchanged.
  DeviceSample toWorld(const DeviceSample& device);

  /// Transforms a wrench from world axes to the device's base axes.
  Wrench toDevice(const Wrench& world) const;

  /// Shifts the workspace so that the device's present pose becomes `world`.
  void recentre(const DeviceSample& device, const glm::dvec3& world);

  /// The device's limits in the world: lengths times scale; mass and damping, at equal force, divided by it;
  /// torque, inertia and rotational damping, at equal angles, times scale.
  DeviceLimits inWorld(const DeviceLimits& device) const;

 private:
  glm::dvec3 unshifted(const glm::dvec3& devicePosition) const;

  Pose worldFromBase_;
  double scale_;
  glm::dvec3 shift_{0.0, 0.0, 0.0};  // world, from the clutch and from recentring
  glm::dvec3 last_{0.0, 0.0, 0.0};   // last returned world position
  bool clutched_ = false, started_ = false;
};

}  // namespace tandem::haptics
