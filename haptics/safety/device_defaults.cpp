#include "haptics/safety/device_defaults.h"

#include <algorithm>

#include "haptics/body/virtual_coupling.h"

namespace tandem::haptics {
namespace {

// Of a device's stated damping: what is left is the margin by which a contact at the stiffest stable comes to
// rest.
constexpr double kCountedDamping = 0.5;
// A contact under the passivity controller: it rests at three times the stiffest stable, this is half of
// that. What the hand feels at rest is the spring's own quantum, so it grows with the stiffness: see
// README.md.
constexpr double kControlledShare = 1.5;
// A hand throws at 10 m/s; a workspace scaled up makes its image faster.
constexpr double kHandSpeed = 10.0;             // m/s
constexpr double kWorkspacesPerSecond = 100.0;  // radii a second: 10 m/s for 0.1 m

/// 0: there is no limit.
void keepTo(double most, double& gain) {
  if (most > 0.0) gain = std::min(gain, most);
}

}  // namespace

double stiffestControlled(const DeviceLimits& limits, double dt, double delay) {
  return (delay > 0.0 ? 1.0 : kControlledShare) * stiffestContact(limits, dt, delay);
}

double fitToDevice(const DeviceLimits& limits, double delay, TickParameters& parameters) {
  if (limits.maxForce > 0.0) parameters.forceLimit = limits.maxForce;
  if (limits.maxTorque > 0.0) parameters.torqueLimit = limits.maxTorque;
  const double stiffest = stiffestContact(limits, parameters.dt, delay);
  const double controlled = stiffestControlled(limits, parameters.dt, delay);
  if (stiffest > 0.0) {
    parameters.stiffnessLimit = controlled;
    parameters.stiffness = std::min(parameters.stiffness, controlled);
    parameters.passivity = true;
    parameters.deviceDamping = kCountedDamping * limits.damping;
  }
  const CouplingGains most = stiffestGrasp(limits, parameters.dt, delay);
  keepTo(most.stiffness, parameters.graspStiffness);
  keepTo(most.damping, parameters.graspDamping);
  keepTo(most.rotStiffness, parameters.graspRotStiffness);
  keepTo(most.rotDamping, parameters.graspRotDamping);
  // A hand with some tens of grams of device on it throbs against more, however soft the surface.
  parameters.dampingLimit = parameters.fieldDampingLimit;
  parameters.maxDeviceSpeed = std::max(kHandSpeed, kWorkspacesPerSecond * limits.workspaceRadius);
  if (limits.rate > 0.0) parameters.staleAfter = std::max(parameters.staleAfter, 5.0 / limits.rate);
  return controlled;
}

}  // namespace tandem::haptics
