#include "assets/base/pose.h"

#include <cmath>

namespace tandem {

glm::dvec3 rotationVector(const glm::dquat& rotation) {
  const glm::dquat q = rotation.w < 0.0 ? -rotation : rotation;
  const glm::dvec3 v(q.x, q.y, q.z);
  const double sine = glm::length(v);
  // atan2 keeps full precision at both small angles and near pi, where acos loses half the digits.
  const double angle = 2.0 * std::atan2(sine, q.w);
  return sine > 1e-12 ? v * (angle / sine) : v * 2.0;
}

glm::dquat fromRotationVector(const glm::dvec3& rotation) {
  const double angle = glm::length(rotation);
  const double half = 0.5 * angle;
  // sin(a/2)/a by its series where the quotient would be 0/0.
  const double scale = angle > 1e-6 ? std::sin(half) / angle : 0.5 - angle * angle / 48.0;
  return glm::normalize(
      glm::dquat(std::cos(half), rotation.x * scale, rotation.y * scale, rotation.z * scale));
}

Pose integrate(const Pose& worldFromBody, const Twist& twist, double dt) {
  return {worldFromBody.position + twist.linear * dt,
          glm::normalize(fromRotationVector(twist.angular * dt) * worldFromBody.orientation)};
}

Pose interpolate(const Pose& from, const Pose& to, double s) {
  const glm::dvec3 turn = rotationVector(to.orientation * glm::conjugate(from.orientation));
  return {glm::mix(from.position, to.position, s),
          glm::normalize(fromRotationVector(turn * s) * from.orientation)};
}

bool isValid(const Pose& pose) {
  const glm::dvec3& p = pose.position;
  const glm::dquat& q = pose.orientation;
  const double norm = q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z;
  return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z) && std::abs(norm - 1.0) < 2e-6;
}

}  // namespace tandem
