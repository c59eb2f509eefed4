#pragma once

// Impedance device of the class of a desktop arm (Phantom Omni, Geomagic Touch): three motors on the base
// move two links, and an unactuated gimbal senses the orientation of the stylus. Pure: no clock, no bus. A
// driver of a real arm supplies encoder counts and sends the currents; SimulatedArm does both itself.
//
// Base axes: x right, y up, z towards the user. Both links are driven from the base (parallelogram), so q2
// and q3 are angles to the horizontal and the vertical, not to each other.
//
//   r = L1 cos q2 + L2 sin q3             tip = origin + (-r sin q1,  L1 sin q2 - L2 cos q3,  r cos q1)
//   tau = J^T F     I = tau / (N k_t)     det J = +-r L1 L2 cos(q2 - q3)
//
// Kinematics: Silva, Ramirez, Vega & Rodriguez 2009, "PHANToM OMNI haptic device: kinematic and
// manipulability". Statics: Craig, "Introduction to Robotics", 5.9; Siciliano et al., "Robotics", 3.8.

#include <glm/mat3x3.hpp>

#include "assets/base/pose.h"

namespace tandem::haptics {

/// Motor angles (q1 turns the base, q2 lifts the upper arm, q3 swings the forearm) and gimbal angles, rad.
struct ArmJoints {
  glm::dvec3 arm{0.0, 0.0, 0.0};
  glm::dvec3 gimbal{0.0, 0.0, 0.0};  // about the forearm, across it, about the stylus
};

/// Geometry from Silva et al. 2009, joint ranges from published URDF models of the Touch; forces, mass and
/// resolution from the data sheet. The sheet names no motor: k_t is that of the Maxon RE 25 class, N a usual
/// cable reduction, and the currents are those that 3.3 N and 0.88 N then require at the nominal pose.
struct ImpedanceArmParameters {
  double upperArm = 0.135, forearm = 0.135;  // m: L1, L2
  glm::dvec3 origin{0.0, 0.025, -0.17};      // m, base axes: where the axes of q1 and q2 cross

  glm::dvec3 lowest{-0.98, 0.0, -0.81};  // rad: of q1, q2 and q3 - q2
  glm::dvec3 highest{0.98, 1.75, 1.25};  // rad
  double highestForearm = 2.5;           // rad: of q3 itself; the housing stops the tip before the axis of q1
  glm::dvec3 nominal{0.0, 0.785, 0.785};  // rad: q in the middle of the workspace

  double countsPerTurn = 15422.0;  // of a motor joint: 0.055 mm at the end of one link
  double gimbalStep = 0.0015;      // rad

  double torqueConstant = 0.0234;  // N·m/A: k_t
  double reduction = 10.0;         // N
  double peakCurrent = 2.7;        // A
  double heldCurrent = 0.72;       // A, continuous
  double windingTime = 20.0;       // s: time constant of the winding's temperature
  double maxForce = 3.3;           // N at the tip

  double mass = 0.045;                               // kg, apparent at the tip
  double upperArmMass = 0.035, forearmMass = 0.035;  // kg, for gravity only; each at the middle of its link
  glm::dvec3 gravity{0.0, -9.81, 0.0};               // m/s^2, base axes, along y
  bool compensateGravity = true;
};

/// Motor command and its effect.
struct ArmCommand {
  glm::dvec3 torque{0.0, 0.0, 0.0};   // N·m at the joints, delivered
  glm::dvec3 current{0.0, 0.0, 0.0};  // A
  glm::dvec3 force{0.0, 0.0, 0.0};    // N at the tip, base axes, felt by the hand
  bool saturated = false;             // the requested force was shortened
};

class ImpedanceArm {
 public:
  explicit ImpedanceArm(const ImpedanceArmParameters& parameters = {});
  const ImpedanceArmParameters& parameters() const { return p_; }

  /// baseFromTip, m. The stylus frame: R_y(-q1) R_x(-q3) R_y(g1) R_x(g2) R_z(g3).
  Pose tip(const ArmJoints& joints) const;

  /// d tip / d q, m/rad: column i for motor joint i. Analytic.
  glm::dmat3 jacobian(const glm::dvec3& arm) const;
  /// Angular Jacobian of the stylus, base axes, rad/rad: `byMotors` of the motor joints, `byGimbal` of the
  /// gimbal's.
  void angularJacobian(const ArmJoints& joints, glm::dmat3& byMotors, glm::dmat3& byGimbal) const;

  /// Manipulability |det J| / (L1 L2 (L1 + L2)), Yoshikawa's measure made dimensionless: 0 where the arm is
  /// stretched, folded or over its own axis.
  double manipulability(const glm::dvec3& arm) const;

  /// Inverse kinematics, each joint stopped at its range. A point out of reach gives the joints that point at
  /// it.
  ArmJoints jointsFor(const Pose& baseFromTip) const;
  glm::dvec3 withinRange(const glm::dvec3& arm) const;

  /// J^T F.
  glm::dvec3 torqueOf(const glm::dvec3& arm, const glm::dvec3& force) const;
  /// Tip force that balances joint torques, J^-T tau. Near a singularity damped least squares (Nakamura &
  /// Hanafusa 1986) keep it bounded; it loses only the direction in which the arm cannot push.
  glm::dvec3 forceOf(const glm::dvec3& arm, const glm::dvec3& torque) const;

  /// Torque in N·m of the links' weight on the joints: -dU/dq.
  glm::dvec3 gravityTorque(const glm::dvec3& arm) const;

  /// Command for a force in N (base axes), shortened without a change of direction to maxForce and to the
  /// present current limit of each motor; gravity compensation is served first. `heat` is the filtered
  /// squared current of each motor, A^2, advanced by dt (s): a motor that was driven hard falls back from
  /// peakCurrent to heldCurrent. A non-finite force counts as zero.
  ArmCommand command(const glm::dvec3& arm, const glm::dvec3& force, glm::dvec3& heat, double dt) const;

  /// As the encoders read them.
  ArmJoints encoded(const ArmJoints& joints) const;

 private:
  ImpedanceArmParameters p_;
};

}  // namespace tandem::haptics
