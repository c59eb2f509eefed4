#pragma once

// Rigid motions. Names read from right to left: worldFromPart maps a point of the part frame to the world's.

#include <glm/gtc/quaternion.hpp>
#include <glm/vec3.hpp>

namespace tandem {

/// A rigid transform: rotation (unit quaternion), then translation in m.
struct Pose {
  glm::dvec3 position{0.0, 0.0, 0.0};
  glm::dquat orientation{1.0, 0.0, 0.0, 0.0};
};

/// The velocity of a rigid body: of its frame's origin in m/s, and angular in rad/s, both in world axes.
struct Twist {
  glm::dvec3 linear{0.0, 0.0, 0.0};
  glm::dvec3 angular{0.0, 0.0, 0.0};
};

/// A force in N and a torque in N·m, in world axes, about a point that the user of the type names.
struct Wrench {
  glm::dvec3 force{0.0, 0.0, 0.0};
  glm::dvec3 torque{0.0, 0.0, 0.0};
};

/// The sum of two wrenches about the same point.
inline Wrench operator+(const Wrench& a, const Wrench& b) { return {a.force + b.force, a.torque + b.torque}; }

/// aFromC = aFromB * bFromC.
inline Pose operator*(const Pose& aFromB, const Pose& bFromC) {
  return {aFromB.position + aFromB.orientation * bFromC.position,
          glm::normalize(aFromB.orientation * bFromC.orientation)};
}

inline Pose inverse(const Pose& aFromB) {
  const glm::dquat bFromA = glm::conjugate(aFromB.orientation);
  return {-(bFromA * aFromB.position), bFromA};
}

inline glm::dvec3 transformPoint(const Pose& aFromB, const glm::dvec3& pointInB) {
  return aFromB.position + aFromB.orientation * pointInB;
}

inline glm::dvec3 transformVector(const Pose& aFromB, const glm::dvec3& vectorInB) {
  return aFromB.orientation * vectorInB;
}

inline bool isStill(const Twist& twist) {
  return twist.linear == glm::dvec3(0.0) && twist.angular == glm::dvec3(0.0);
}

/// Velocity in m/s of the material point that is now at `pointInWorld`, for a body with this pose and twist.
inline glm::dvec3 velocityAt(const Pose& worldFromBody, const Twist& twist, const glm::dvec3& pointInWorld) {
  return twist.linear + glm::cross(twist.angular, pointInWorld - worldFromBody.position);
}

/// The rotation vector (axis times angle in rad, angle in [0, pi]) of a unit quaternion.
glm::dvec3 rotationVector(const glm::dquat& rotation);

/// The unit quaternion of a rotation vector in rad; the inverse of rotationVector.
glm::dquat fromRotationVector(const glm::dvec3& rotation);

/// The pose after moving with a constant twist (world axes) for dt seconds.
Pose integrate(const Pose& worldFromBody, const Twist& twist, double dt);

/// The pose at s in [0, 1] between two poses: linear in position, shortest arc in rotation.
Pose interpolate(const Pose& from, const Pose& to, double s);

/// Whether every number is finite and the quaternion has length 1 within 1e-6.
bool isValid(const Pose& pose);

}  // namespace tandem
