#include "haptics/operator/impedance_arm.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <glm/matrix.hpp>

#include "assets/base/assert.h"
#include "assets/base/constants.h"
#include "haptics/operator/simulated_hand.h"

namespace tandem::haptics {
namespace {

constexpr double kNearSingular = 0.02;  // manipulability below which the inverse is damped

glm::dquat aboutX(double angle) { return {std::cos(0.5 * angle), std::sin(0.5 * angle), 0.0, 0.0}; }
glm::dquat aboutY(double angle) { return {std::cos(0.5 * angle), 0.0, std::sin(0.5 * angle), 0.0}; }
glm::dquat aboutZ(double angle) { return {std::cos(0.5 * angle), 0.0, 0.0, std::sin(0.5 * angle)}; }

glm::dquat forearmTurn(const glm::dvec3& arm) { return aboutY(-arm.x) * aboutX(-arm.z); }

/// The angles a, b, c of R_y(a) R_x(b) R_z(c). At a right angle b only a - c or a + c is determined; a is
/// then 0.
glm::dvec3 gimbalAngles(const glm::dquat& turn) {
  const glm::dmat3 m = glm::mat3_cast(turn);
  const double sine = std::clamp(-m[2].y, -1.0, 1.0);
  if (std::abs(sine) > 1.0 - 1e-12) return {0.0, std::asin(sine), std::atan2(-m[1].x, m[0].x)};
  return {std::atan2(m[2].x, m[2].z), std::asin(sine), std::atan2(m[0].y, m[1].y)};
}

double rounded(double angle, double step) { return step > 0.0 ? step * std::round(angle / step) : angle; }

/// The largest factor s <= 1 for which |base + s wanted| <= limit; `base` itself is within it.
double shareWithin(double base, double wanted, double limit) {
  if (std::abs(base + wanted) <= limit) return 1.0;
  return std::clamp((std::copysign(limit, wanted) - base) / wanted, 0.0, 1.0);
}

}  // namespace

ImpedanceArm::ImpedanceArm(const ImpedanceArmParameters& parameters) : p_(parameters) {
  ASSERT(p_.upperArm > 0.0 && p_.forearm > 0.0 && p_.torqueConstant > 0.0 && p_.reduction > 0.0);
  ASSERT(p_.countsPerTurn > 0.0 && p_.peakCurrent >= p_.heldCurrent && p_.heldCurrent > 0.0);
}

Pose ImpedanceArm::tip(const ArmJoints& joints) const {
  const glm::dvec3& q = joints.arm;
  const double reach = p_.upperArm * std::cos(q.y) + p_.forearm * std::sin(q.z);
  const double height = p_.upperArm * std::sin(q.y) - p_.forearm * std::cos(q.z);
  const glm::dquat gimbal = aboutY(joints.gimbal.x) * aboutX(joints.gimbal.y) * aboutZ(joints.gimbal.z);
  return {p_.origin + glm::dvec3(-reach * std::sin(q.x), height, reach * std::cos(q.x)),
          glm::normalize(forearmTurn(q) * gimbal)};
}

glm::dmat3 ImpedanceArm::jacobian(const glm::dvec3& q) const {
  const double s1 = std::sin(q.x), c1 = std::cos(q.x);
  const double s2 = p_.upperArm * std::sin(q.y), c2 = p_.upperArm * std::cos(q.y);
  const double s3 = p_.forearm * std::sin(q.z), c3 = p_.forearm * std::cos(q.z);
  const double reach = c2 + s3;
  return {glm::dvec3(-reach * c1, 0.0, -reach * s1),  // about the vertical, backwards
          glm::dvec3(s1 * s2, c2, -c1 * s2), glm::dvec3(-s1 * c3, s3, c1 * c3)};
}

void ImpedanceArm::angularJacobian(const ArmJoints& joints, glm::dmat3& byMotors,
                                   glm::dmat3& byGimbal) const {
  const glm::dquat base = aboutY(-joints.arm.x);
  const glm::dquat forearm = forearmTurn(joints.arm);
  const glm::dquat yawed = forearm * aboutY(joints.gimbal.x);
  const glm::dquat pitched = yawed * aboutX(joints.gimbal.y);
  // The upper arm does not rotate the stylus: the parallelogram keeps the forearm at the angle of its own
  // motor.
  byMotors = {glm::dvec3(0.0, -1.0, 0.0), glm::dvec3(0.0), base * glm::dvec3(-1.0, 0.0, 0.0)};
  byGimbal = {forearm * glm::dvec3(0.0, 1.0, 0.0), yawed * glm::dvec3(1.0, 0.0, 0.0),
              pitched * glm::dvec3(0.0, 0.0, 1.0)};
}

double ImpedanceArm::manipulability(const glm::dvec3& q) const {
  const double reach = p_.upperArm * std::cos(q.y) + p_.forearm * std::sin(q.z);
  return std::abs(reach * std::cos(q.y - q.z)) / (p_.upperArm + p_.forearm);
}

glm::dvec3 ImpedanceArm::withinRange(const glm::dvec3& q) const {
  const double lift = std::clamp(q.y, p_.lowest.y, p_.highest.y);
  return {std::clamp(q.x, p_.lowest.x, p_.highest.x), lift,
          std::min(lift + std::clamp(q.z - lift, p_.lowest.z, p_.highest.z), p_.highestForearm)};
}

ArmJoints ImpedanceArm::jointsFor(const Pose& baseFromTip) const {
  const glm::dvec3 d = baseFromTip.position - p_.origin;
  const double reach = std::hypot(d.x, d.z);
  const double l1 = p_.upperArm, l2 = p_.forearm;
  // Planar two-link inverse kinematics, elbow up; the angle between the links is -pi/2 when q2 = q3.
  const double cosine = (reach * reach + d.y * d.y - l1 * l1 - l2 * l2) / (2.0 * l1 * l2);
  const double bend = -std::acos(std::clamp(cosine, -1.0, 1.0));
  const double lift = std::atan2(d.y, reach) - std::atan2(l2 * std::sin(bend), l1 + l2 * std::cos(bend));
  ArmJoints joints;
  joints.arm = withinRange({reach > 0.0 ? std::atan2(-d.x, d.z) : 0.0, lift, lift + bend + 0.5 * kPi});
  joints.gimbal = gimbalAngles(glm::conjugate(forearmTurn(joints.arm)) * baseFromTip.orientation);
  return joints;
}

glm::dvec3 ImpedanceArm::torqueOf(const glm::dvec3& arm, const glm::dvec3& force) const {
  return glm::transpose(jacobian(arm)) * force;
}

glm::dvec3 ImpedanceArm::forceOf(const glm::dvec3& arm, const glm::dvec3& torque) const {
  const glm::dmat3 j = jacobian(arm);
  const double length = p_.upperArm + p_.forearm;
  const double lack = std::max(0.0, 1.0 - manipulability(arm) / kNearSingular);
  if (lack == 0.0) return glm::inverse(glm::transpose(j)) * torque;
  const double damping = lack * lack * kNearSingular * length * kNearSingular * length;
  return glm::inverse(j * glm::transpose(j) + glm::dmat3(damping)) * (j * torque);
}

glm::dvec3 ImpedanceArm::gravityTorque(const glm::dvec3& q) const {
  const double lifted = (0.5 * p_.upperArmMass + p_.forearmMass) * p_.upperArm;
  const double swung = 0.5 * p_.forearmMass * p_.forearm;
  return p_.gravity.y * glm::dvec3(0.0, lifted * std::cos(q.y), swung * std::sin(q.z));
}

ArmCommand ImpedanceArm::command(const glm::dvec3& arm, const glm::dvec3& force, glm::dvec3& heat,
                                 double dt) const {
  ArmCommand out;
  const double motor = p_.reduction * p_.torqueConstant;  // N·m/A at the joint
  const glm::dvec3 weight = gravityTorque(arm);
  const glm::dvec3 held = p_.compensateGravity ? -weight : glm::dvec3(0.0);
  const glm::dvec3 limitedForce = limited(force, p_.maxForce);
  const glm::dvec3 wanted = torqueOf(arm, limitedForce);
  const double heldSquare = p_.heldCurrent * p_.heldCurrent;
  glm::dvec3 base(0.0);
  double share = 1.0;
  for (int i = 0; i < 3; ++i) {
    // The limit falls from the full current of a cool winding to the continuous current as the heat nears
    // that level.
    const double cool = std::clamp(10.0 * (1.0 - heat[i] / heldSquare), 0.0, 1.0);
    const double limit = motor * (p_.heldCurrent + cool * (p_.peakCurrent - p_.heldCurrent));
    base[i] = std::clamp(held[i], -limit, limit);
    if (wanted[i] != 0.0) share = std::min(share, shareWithin(base[i], wanted[i], limit));
  }
  out.torque = base + share * wanted;
  out.current = out.torque / motor;
  out.force = forceOf(arm, out.torque + weight);
  out.saturated = share < 1.0 || limitedForce != force;
  const double keep = std::exp(-dt / p_.windingTime);
  heat = keep * heat + (1.0 - keep) * out.current * out.current;
  return out;
}

ArmJoints ImpedanceArm::encoded(const ArmJoints& joints) const {
  ArmJoints read;
  for (int i = 0; i < 3; ++i) {
    read.arm[i] = rounded(joints.arm[i], 2.0 * kPi / p_.countsPerTurn);
    read.gimbal[i] = rounded(joints.gimbal[i], p_.gimbalStep);
  }
  return read;
}

}  // namespace tandem::haptics
