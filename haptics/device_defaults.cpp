#include "haptics/device_defaults.h"

#include <algorithm>

#include "haptics/virtual_coupling.h"

namespace tandem::haptics {

double fitToDevice(const DeviceLimits& limits, double delay, TickParameters& parameters) {
  if (limits.maxForce > 0.0) parameters.forceLimit = limits.maxForce;
  if (limits.maxTorque > 0.0) parameters.torqueLimit = limits.maxTorque;
  const double stiffest = stiffestContact(limits, parameters.dt, delay);
  if (stiffest > 0.0) {
    parameters.stiffness = std::min(parameters.stiffness, stiffest);
    parameters.graspStiffness = std::min(parameters.graspStiffness, stiffest);
  }
  return stiffest;
}

}  // namespace tandem::haptics
