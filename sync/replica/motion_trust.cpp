#include "sync/replica/motion_trust.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

namespace tandem::sync {
namespace {

constexpr double kLeastTick = 0.5e-3;  // s
constexpr double kResumed = 1.05;

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

void MotionTrust::accuse(double speed, double step, double dt) {
  breaches_ = std::max(0.0, breaches_ - kForgets * dt);
  gained_ = gained_ / (1.0 + dt / kForgives) + step;
  reached_ /= 1.0 + dt / kRemembers;
  const double most = kGross + kGrossShare * reached_;
  if (gained_ > most || speed > kMaxSpeed) {
    breaches_ += std::clamp(gained_ / most, 1.0, kMostAtOnce);
    gained_ = 0.0;
  }
  reached_ = std::max(reached_, std::min(speed, reached_ + acceleration_ * dt));
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
  const double speed = std::sqrt(glm::dot(velocity_.linear, velocity_.linear) +
                                 glm::dot(velocity_.atRadius, velocity_.atRadius));
  // Playing may run at half its speed for a while (PlayOutDelay), and then the speed is back at once.
  const double most = speed <= kResumed * speed_ ? 2.0 * kResumed : 1.0;
  const double kept = square > 0.0 ? std::clamp(along / square, 0.0, most) : 0.0;
  const glm::dvec3 gained = velocity_.linear - kept * before.linear,
                   turned = velocity_.atRadius - kept * before.atRadius;
  const double step = std::sqrt(glm::dot(gained, gained) + glm::dot(turned, turned)) - acceleration_ * dt;
  accuse(speed, std::max(0.0, step), dt);
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
