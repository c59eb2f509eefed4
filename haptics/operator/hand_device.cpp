#include "haptics/operator/hand_device.h"

#include <algorithm>
#include <cmath>

#include "assets/base/finite.h"

namespace tandem::haptics {
namespace {

constexpr double kLongestInterval = 0.02;  // s
constexpr double kLongestStep = 2e-3;      // s: the grip's fastest mode is then still resolved

}  // namespace

bool isValid(const HandTarget& target) {
  return isValid(target.worldFromTarget) && isFinite(target.velocity) && isFinite(target.acceleration);
}

double pollInterval(double last, double now) {
  const double interval = now - last;
  return interval > 0.0 ? std::min(interval, kLongestInterval) : 0.0;  // also 0 when not a number
}

HandDevice::HandDevice(const Pose& worldFromStart, const ArmParameters& arm,
                       const SimulatedDeviceParameters& device, double workspaceRadius)
    : parameters_(device), workspaceRadius_(workspaceRadius), hand_(arm, device, worldFromStart) {}

DeviceLimits HandDevice::limits() const {
  DeviceLimits limits;
  limits.sensedAxes = 6;
  limits.actuatedAxes = 3;
  limits.maxForce = parameters_.forceMax;
  limits.mass = parameters_.mass;
  limits.damping = parameters_.damping;
  limits.quantum = parameters_.quantum;
  limits.workspaceRadius = workspaceRadius_;
  return limits;
}

Status HandDevice::open() {
  started_ = false;
  force_ = glm::dvec3{0.0, 0.0, 0.0};
  return {};
}

DeviceSample HandDevice::poll(double now) {
  if (!started_) {
    lastPoll_ = lastApply_ = now;
    started_ = true;
  }
  beginPoll(now);
  if (now - lastApply_ > kForceWatchdog) force_ = glm::dvec3{0.0, 0.0, 0.0};
  const double interval = pollInterval(lastPoll_, now);
  if (interval > 0.0) {
    const int steps = static_cast<int>(std::ceil(interval / kLongestStep));
    const double dt = interval / steps;
    for (int i = 0; i < steps; ++i) {
      hand_.step(nextTarget(dt), actuated(force_, dt), dt);
      afterStep(hand_, dt);
    }
  }
  lastPoll_ = now;
  DeviceSample sample = reading(now);
  sample.buttons = pressedButtons();
  return sample;
}

void HandDevice::apply(const Wrench& toHand) {
  force_ = toHand.force;
  lastApply_ = lastPoll_;
}

}  // namespace tandem::haptics
