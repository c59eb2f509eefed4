#include "haptics/devices/virtual_stylus.h"

#include <cmath>
#include <glm/geometric.hpp>

#include "haptics/devices/simulated_device.h"

namespace tandem::haptics {
namespace {

constexpr double kLongestStep = 2e-3;  // s

/// One axis vector of a critically damped follower: `offset` from the target and its rate, after dt. Exact
/// solution.
void settle(glm::dvec3& offset, glm::dvec3& rate, double omega, double dt) {
  const glm::dvec3 lead = (rate + omega * offset) * dt;
  const double decay = std::exp(-omega * dt);
  offset = (offset + lead) * decay;
  rate = (rate - omega * lead) * decay;
}

}  // namespace

void PoseFilter::step(const Pose& target, double time, double maxSpeed, double dt) {
  const double omega = 1.0 / time;
  // From rest at distance d the follower's greatest speed is omega d / e: a nearer target limits the speed
  // smoothly.
  glm::dvec3 offset = limited(pose_.position - target.position, 2.0 * maxSpeed / omega);
  const glm::dvec3 aim = pose_.position - offset;
  const glm::dvec3 before = twist_.linear;
  settle(offset, twist_.linear, omega, dt);
  pose_.position = aim + offset;
  acceleration_ = (twist_.linear - before) / dt;

  glm::dvec3 turn = rotationVector(pose_.orientation * glm::conjugate(target.orientation));
  settle(turn, twist_.angular, omega, dt);
  pose_.orientation = glm::normalize(fromRotationVector(turn) * target.orientation);
}

void PoseFilter::reset(const Pose& pose) { *this = PoseFilter(pose); }

VirtualStylus::VirtualStylus(const Pose& worldFromStart, const VirtualStylusSettings& settings)
    : settings_(settings),
      hand_(settings.arm, settings.device, worldFromStart),
      filter_(worldFromStart),
      target_(worldFromStart) {}

DeviceLimits VirtualStylus::limits() const {
  DeviceLimits limits;
  limits.sensedAxes = 6;
  limits.actuatedAxes = 3;
  limits.maxForce = settings_.device.forceMax;
  limits.mass = settings_.device.mass;
  limits.damping = settings_.device.damping;
  limits.quantum = settings_.device.quantum;
  limits.workspaceRadius = settings_.workspaceRadius;
  return limits;
}

Status VirtualStylus::open() {
  started_ = false;
  force_ = glm::dvec3{0.0, 0.0, 0.0};
  return {};
}

DeviceSample VirtualStylus::poll(double now) {
  const Pose& target = target_.latest();
  if (!started_) {
    lastPoll_ = lastApply_ = now;
    started_ = true;
  }
  const double interval = pollInterval(lastPoll_, now);
  if (now - lastApply_ > kForceWatchdog) force_ = glm::dvec3{0.0, 0.0, 0.0};
  if (interval > 0.0) {
    const int steps = static_cast<int>(std::ceil(interval / kLongestStep));
    for (int i = 0; i < steps; ++i) {
      filter_.step(target, settings_.smoothingTime, settings_.maxSpeed, interval / steps);
      hand_.step({filter_.pose(), filter_.twist().linear, filter_.acceleration(), true}, force_,
                 interval / steps);
    }
  }
  lastPoll_ = now;
  DeviceSample sample = hand_.sample(now);
  sample.buttons = buttons_.load(std::memory_order_relaxed);
  return sample;
}

void VirtualStylus::apply(const Wrench& toHand) {
  force_ = toHand.force;
  lastApply_ = lastPoll_;
}

void VirtualStylus::setTarget(const glm::dvec3& worldPosition, const glm::dquat& orientation) {
  const double length = glm::length(orientation);
  if (!(length > 0.0) || !std::isfinite(length)) return;
  const Pose target{worldPosition, orientation / length};
  if (isValid(target)) target_.write(target);
}

}  // namespace tandem::haptics
