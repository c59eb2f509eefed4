#pragma once

// Six axes of one unit: an angle counts as the displacement at the end of a lever. Power needs no
// scale, (torque / length) . (length spin) = torque . spin, so force and torque share one impedance, one
// spring and one account of energy.

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "assets/base/pose.h"

namespace tandem::haptics {

/// Three axes along and three about the world's axes: m, m/s, N or sqrt(W), whichever it is, in all six.
struct SixAxes {
  glm::dvec3 along{0.0, 0.0, 0.0};
  glm::dvec3 about{0.0, 0.0, 0.0};

  SixAxes& operator+=(const SixAxes& other) { return along += other.along, about += other.about, *this; }
  SixAxes& operator-=(const SixAxes& other) { return along -= other.along, about -= other.about, *this; }
};

inline SixAxes operator+(SixAxes a, const SixAxes& b) { return a += b; }
inline SixAxes operator-(SixAxes a, const SixAxes& b) { return a -= b; }
inline SixAxes operator*(double s, const SixAxes& a) { return {s * a.along, s * a.about}; }
inline double dot(const SixAxes& a, const SixAxes& b) {
  return glm::dot(a.along, b.along) + glm::dot(a.about, b.about);
}
inline double length(const SixAxes& a) { return std::sqrt(dot(a, a)); }

/// `a` shortened to at most `limit` in length, its direction kept.
inline SixAxes shortened(const SixAxes& a, double limit) {
  const double size = length(a);
  return size > limit ? (limit / size) * a : a;
}

inline glm::dvec3 shortened(const glm::dvec3& a, double limit) {
  const double size = glm::length(a);
  return size > limit ? (limit / size) * a : a;
}

/// The axes of a twist or of a displacement (rotation vector), the lever `lever` m long.
inline SixAxes axesOf(const Twist& twist, double lever) { return {twist.linear, lever * twist.angular}; }
inline Wrench wrenchOf(const SixAxes& force, double lever) { return {force.along, lever * force.about}; }

/// The displacement from one pose to another.
inline SixAxes displacementBetween(const Pose& from, const Pose& to, double lever) {
  return {to.position - from.position,
          lever * rotationVector(to.orientation * glm::conjugate(from.orientation))};
}

/// The pose after a displacement.
inline Pose applied(const Pose& from, const SixAxes& displacement, double lever) {
  return {from.position + displacement.along,
          glm::normalize(fromRotationVector(displacement.about / lever) * from.orientation)};
}

}  // namespace tandem::haptics
