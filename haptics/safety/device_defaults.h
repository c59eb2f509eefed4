#pragma once

// What a tick may do on one device: its limits as parameters, and stiffnesses that the pair of hand and
// device is stable with.

#include "haptics/base/device.h"
#include "haptics/base/tick_types.h"

namespace tandem::haptics {

/// The stiffest contact that the passivity controller keeps at rest on a device, N/m: 1.5 times
/// stiffestContact(); no more than that with a `delay` (s), for which the controller was not measured.
double stiffestControlled(const DeviceLimits& limits, double dt, double delay);

/// Limits and stiffnesses of `parameters` as `limits` allow, `delay` s being that between device and loop:
/// force and torque limits where the device states any; contact no stiffer than stiffestControlled(),
/// whatever a material states, with that controller on; the gains of a grasp within stiffestGrasp(); readings
/// that jump faster than a hand, or stand still, refused. Returns stiffestControlled(), N/m; 0 for a device
/// that drives nothing or states no damping: then stiffnesses stay as they are.
double fitToDevice(const DeviceLimits& limits, double delay, TickParameters& parameters);

}  // namespace tandem::haptics
