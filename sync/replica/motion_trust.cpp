#include "sync/replica/motion_trust.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

namespace tandem::sync {
namespace {

constexpr double kLeastTick = 1e-4;  // s

}  // namespace

MotionTrust::MotionTrust(double mass, double radius, const Pose& worldFromPart)
    : acceleration_(kMaxAcceleration + (mass > 0.0 ? kMaxForce / mass : 0.0)),
      radius_(radius),
      last_(worldFromPart) {}

MotionTrust::Velocity MotionTrust::velocityTo(const Pose& worldFromPart, double dt) const {
  Velocity velocity{(worldFromPart.position - last_.position) / dt, {0.0, 0.0, 0.0}};
  if (worldFromPart.orientation != last_.orientation)
    velocity.atRadius =
        rotationVector(worldFromPart.orientation * glm::conjugate(last_.orientation)) * (radius_ / dt);
  return velocity;
}

void MotionTrust::jump(const Pose& from, const Pose& to) {
  const glm::dvec3 turned = radius_ * rotationVector(to.orientation * glm::conjugate(from.orientation));
  const double way = glm::length(to.position - from.position) + glm::length(turned);
  if (way > kJump + kJumpTime * speed_) suspects_ = kSuspects;
}

bool MotionTrust::advance(const Pose& worldFromPart, double dt) {
  dt = std::max(dt, kLeastTick);
  const Velocity before = velocity_;
  velocity_ = velocityTo(worldFromPart, dt);
  last_ = worldFromPart;
  suspects_ = std::max(0.0, suspects_ - dt);
  const double square = glm::dot(before.linear, before.linear) + glm::dot(before.atRadius, before.atRadius);
  const double along =
      glm::dot(before.linear, velocity_.linear) + glm::dot(before.atRadius, velocity_.atRadius);
  const double kept = square > 0.0 ? std::clamp(along / square, 0.0, 1.0) : 0.0;
  const glm::dvec3 gained = velocity_.linear - kept * before.linear,
                   turned = velocity_.atRadius - kept * before.atRadius;
  const double step = std::sqrt(glm::dot(gained, gained) + glm::dot(turned, turned)) - acceleration_ * dt;
  const double speed = std::sqrt(glm::dot(velocity_.linear, velocity_.linear) +
                                 glm::dot(velocity_.atRadius, velocity_.atRadius));
  forgiven_ = forgiven_ / (1.0 + dt / kForgives) + std::max(0.0, step);
  speed_ /= 1.0 + dt / kRemembers;
  if (forgiven_ > kSlack + kShare * speed_ || speed > kMaxSpeed) {
    forgiven_ = 0.0;
    suspects_ = kSuspects;
  }
  if (!suspect()) speed_ = std::max(speed_, std::min(speed, speed_ + acceleration_ * dt));
  return suspect();
}

}  // namespace tandem::sync
