#include "haptics/devices/simulated_device.h"

#include <algorithm>
#include <cmath>

namespace tandem::haptics {
namespace {

constexpr double kLongestInterval = 0.02;  // s
constexpr double kLongestStep = 2e-3;      // s: the grip's fastest mode is then still resolved

bool isFinite(const glm::dvec3& v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }

HandTarget restingAt(const Pose& pose) {
  HandTarget target;
  target.worldFromTarget = pose;
  return target;
}

}  // namespace

bool isValid(const HandTarget& target) {
  return isValid(target.worldFromTarget) && isFinite(target.velocity) && isFinite(target.acceleration);
}

double pollInterval(double last, double now) {
  const double interval = now - last;
  return interval > 0.0 ? std::min(interval, kLongestInterval) : 0.0;  // also 0 when not a number
}

SimulatedDevice::SimulatedDevice(const Pose& worldFromStart, const ArmParameters& arm,
                                 const SimulatedDeviceParameters& device)
    : parameters_(device), hand_(arm, device, worldFromStart), target_(restingAt(worldFromStart)) {}

DeviceLimits SimulatedDevice::limits() const {
  DeviceLimits limits;
  limits.sensedAxes = 6;
  limits.actuatedAxes = 3;
  limits.maxForce = parameters_.forceMax;
  limits.mass = parameters_.mass;
  limits.damping = parameters_.damping;
  limits.quantum = parameters_.quantum;
  limits.workspaceRadius = 0.15;
  return limits;
}

Status SimulatedDevice::open() {
  started_ = false;
  force_ = glm::dvec3{0.0, 0.0, 0.0};
  return {};
}

DeviceSample SimulatedDevice::poll(double now) {
  const HandTarget& target = target_.latest();
  if (!started_) {
    lastPoll_ = lastApply_ = now;
    started_ = true;
  }
  const double interval = pollInterval(lastPoll_, now);
  if (now - lastApply_ > kForceWatchdog) force_ = glm::dvec3{0.0, 0.0, 0.0};
  if (interval > 0.0) {
    const int steps = static_cast<int>(std::ceil(interval / kLongestStep));
    for (int i = 0; i < steps; ++i) hand_.step(target, force_, interval / steps);
  }
  lastPoll_ = now;
  DeviceSample sample = hand_.sample(now);
  sample.buttons = buttons_.load(std::memory_order_relaxed);
  return sample;
}

void SimulatedDevice::apply(const Wrench& toHand) {
  force_ = toHand.force;
  lastApply_ = lastPoll_;
}

void SimulatedDevice::setTarget(const HandTarget& target) {
  if (isValid(target)) target_.write(target);
}

}  // namespace tandem::haptics
