#pragma once

// What a tick may do on one device: its limits as parameters, and stiffnesses that the pair of hand and
// device is stable with.

#include "haptics/device.h"
#include "haptics/tick.h"

namespace tandem::haptics {

/// Limits and stiffnesses of `parameters` as `limits` allow, `delay` s being that between device and loop:
/// force and torque limits where the device states any; contact and grasp no stiffer than stiffestContact(),
/// whatever a material states, with the passivity controller behind it; readings that jump faster than a
/// hand, or stand still, refused. Returns stiffestContact(), N/m; 0 for a device that drives nothing or
/// states no damping: then stiffnesses stay as they are.
double fitToDevice(const DeviceLimits& limits, double delay, TickParameters& parameters);

}  // namespace tandem::haptics
