#pragma once

// What a tick may do on one device: its limits as parameters, and stiffnesses that the pair of hand and
// device is stable with.

#include "haptics/device.h"
#include "haptics/tick.h"

namespace tandem::haptics {

/// Limits and stiffnesses of `parameters` as `limits` allow, `delay` s being that between device and loop:
/// force and torque limits where the device states any, and the default contact and grasp stiffness no
/// stiffer than stiffestContact(). A material that states its own stiffness keeps it. Returns
/// stiffestContact(), N/m.
double fitToDevice(const DeviceLimits& limits, double delay, TickParameters& parameters);

}  // namespace tandem::haptics
