#include "haptics/operator/virtual_stylus.h"

#include <cmath>
#include <glm/geometric.hpp>

namespace tandem::haptics {
namespace {

/// Exact solution of a critically damped follower after dt, for one vector: `offset` from the target and its
/// rate.
void followCritically(glm::dvec3& offset, glm::dvec3& rate, double omega, double dt) {
  const glm::dvec3 lead = (rate + omega * offset) * dt;
  const double decay = std::exp(-omega * dt);
  offset = (offset + lead) * decay;
  rate = (rate - omega * lead) * decay;
}

}  // namespace

void PoseFilter::step(const Pose& target, double time, double maxSpeed, double dt) {
  const double omega = 1.0 / time;
  // From rest at distance d the follower's peak speed is omega d / e, so a nearer target limits the speed
  // smoothly.
  glm::dvec3 offset = limited(pose_.position - target.position, 2.0 * maxSpeed / omega);
  const glm::dvec3 aim = pose_.position - offset;
  const glm::dvec3 before = twist_.linear;
  followCritically(offset, twist_.linear, omega, dt);
  pose_.position = aim + offset;
  acceleration_ = (twist_.linear - before) / dt;

  glm::dvec3 rotation = rotationVector(pose_.orientation * glm::conjugate(target.orientation));
  followCritically(rotation, twist_.angular, omega, dt);
  pose_.orientation = glm::normalize(fromRotationVector(rotation) * target.orientation);
}

void PoseFilter::reset(const Pose& pose) { *this = PoseFilter(pose); }

VirtualStylus::VirtualStylus(const Pose& worldFromStart, const VirtualStylusSettings& settings)
    : HandDevice(worldFromStart, settings.arm, settings.device, settings.workspaceRadius),
      settings_(settings),
      filter_(worldFromStart),
      target_(worldFromStart) {}

HandTarget VirtualStylus::nextTarget(double dt) {
  filter_.step(target_.latest(), settings_.smoothingTime, settings_.maxSpeed, dt);
  return {filter_.pose(), filter_.twist().linear, filter_.acceleration(), true};
}

void VirtualStylus::setTarget(const glm::dvec3& worldPosition, const glm::dquat& orientation) {
  const double length = glm::length(orientation);
  if (!(length > 0.0) || !std::isfinite(length)) return;
  const Pose target{worldPosition, orientation / length};
  if (isValid(target)) target_.write(target);
}

}  // namespace tandem::haptics
