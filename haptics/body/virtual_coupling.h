#pragma once

// The virtual coupling: the spring and damper between a device and a held body, and how stiff a device can
// render it.

#include <array>
#include <span>

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

#include "assets/base/pose.h"
#include "haptics/base/device.h"

namespace tandem::haptics {

/// Gains of a six-axis virtual coupling.
struct CouplingGains {
  double stiffness = 0.0;     // N/m
  double damping = 0.0;       // N·s/m
  double rotStiffness = 0.0;  // N·m/rad
  double rotDamping = 0.0;    // N·m·s/rad
};

/// A rigid body for integration: pose and twist of its part frame, mass properties about the centre of mass.
struct RigidBody {
  double mass = 1.0;                       // kg, > 0
  glm::dvec3 centreOfMass{0.0, 0.0, 0.0};  // m, body frame
  glm::dmat3 inertia{1.0};                 // kg·m^2, about the centre of mass, body axes, positive definite
  Pose worldFromBody;
  Twist twist;  // of the body frame's origin
};

// Couplings on one body: two hands, or one hand and a tool; its links; the spring that leads it through an
// outage; force fields.
inline constexpr int kMaxCouplings = 5;

/// A virtual coupling from a grip on a body to a device.
struct Coupling {
  Pose bodyFromGrip, worldFromDevice;
  Twist device;
  CouplingGains gains;
};

/// Terms of a coupling in one step.
struct CouplingForce {
  glm::dvec3 arm{0.0, 0.0, 0.0};     // m, from the centre of mass to the grip
  glm::dvec3 force{0.0, 0.0, 0.0};   // N, on the body if it stood still
  glm::dvec3 torque{0.0, 0.0, 0.0};  // N·m
  double damping = 0.0;              // B, N·s/m
  double drag = 0.0, rotDrag = 0.0;  // B + T K, linear and angular

  /// m/s, of the grip on a body that moves with this velocity and spin.
  glm::dvec3 gripVelocity(const glm::dvec3& velocity, const glm::dvec3& spin) const {
    return velocity + glm::cross(spin, arm);
  }

  /// Wrench of the coupling on the hand when the body has moved with this velocity and spin.
  Wrench onHand(const glm::dvec3& velocity, const glm::dvec3& spin) const {
    return {drag * gripVelocity(velocity, spin) - force, rotDrag * spin - torque};
  }
};

/// One step of a coupled body without contacts:
///     A (v - v_free) = impulse of contacts, N·s,     A = M + T sum_i G_i^T (B_i + T K_i) G_i
/// v = (velocity of the centre of mass, spin), world axes.
struct CoupledStep {
  std::array<std::array<double, 6>, 6> root{};  // L, lower triangle, A = L L^T; kg, kg·m, kg·m^2
  glm::dvec3 freeVelocity{0.0, 0.0, 0.0};       // m/s
  glm::dvec3 freeSpin{0.0, 0.0, 0.0};           // rad/s
  std::array<CouplingForce, kMaxCouplings> couplings;
};

/// The step of a body under at most kMaxCouplings couplings from grip frames to device frames, `load` about
/// its centre of mass and `acceleration` (m/s^2, gravity), integrated as in stepCoupledBody().
CoupledStep coupleBody(const RigidBody& body, std::span<const Coupling> couplings, const Wrench& load,
                       const glm::dvec3& acceleration, double dt);

/// The step of a body without couplings: it keeps `share` (0..1) of its velocity.
CoupledStep coast(const RigidBody& body, double share);

/// The step of a body that has one axis through its centre of mass (unit, world), along which it slides or
/// about which it turns at `rate` (m/s or rad/s) with `inertia` (kg or kg·m^2). Across the axis it is so
/// heavy that nothing moves it; `size` m compares its rotations with its displacements.
CoupledStep guidedStep(const glm::dvec3& axis, bool turns, double rate, double inertia, double size);

/// Sets the velocity of a body's centre of mass and its spin; the pose stays.
void setVelocity(RigidBody& body, const glm::dvec3& velocity, const glm::dvec3& spin);

/// Moves a body by dt with this velocity of its centre of mass and this spin.
void moveBody(RigidBody& body, const glm::dvec3& velocity, const glm::dvec3& spin, double dt);

/// Advances a body by dt (s) under the coupling from its grip frame to the device's frame and `acceleration`
/// (m/s^2, gravity). Returns the wrench of the coupling on the hand at the device's tip, the exact reaction
/// to what acts on the body in this step.
///
/// The springs are evaluated at the end of the step (backward Euler, one 6 x 6 solve), as in McNeely,
/// Puterbaugh & Troy 1999 with the integration of Otaduy & Lin 2006, "A modular haptic rendering algorithm
/// for stable and transparent 6-DOF manipulation". Any mass, inertia and gain is stable at any dt, at the
/// price of some damping. The gyroscopic torque is left out: it is small at the speeds of a hand, and an
/// explicit evaluation could feed energy in.
Wrench stepCoupledBody(RigidBody& body, const Pose& bodyFromGrip, const Pose& worldFromDevice,
                       const Twist& device, const CouplingGains& gains, const glm::dvec3& acceleration,
                       double dt);

/// The stiffest virtual wall that this device renders stably, N/m: the lesser of
///   2 b / T                 energy that holding a position for a tick creates (Colgate & Brown 1994; in this
///                           form, with the device's damping b, Abbott & Okamura 2005)
///   (b + B) / (T/2 + t_d)   phase lag of the hold and of the loop's delay (Gil, Sanchez, Hulin, Preusche &
///                           Hirzinger 2009, for B well below its own limit)
/// with b the device's physical damping (N·s/m), B the coupling's, T the period and t_d the delay (s).
double stiffestStable(double deviceDamping, double period, double delay, double couplingDamping);

/// stiffestStable() for a device as it describes itself, without damping of the coupling: the default limit
/// of a contact, N/m. 0 for a device without motors or without stated damping.
double stiffestContact(const DeviceLimits& device, double dt, double delay);

/// The largest gains of the coupling to a held part that keep the loop through a device passive (K, K_r) and
/// its damper stable (B, B_r). A gain is 0 where the device does not drive that axis or does not state what
/// decides it.
///     K <= b / (T/2 + t_d),   K_r <= b_r / (T/2 + t_d),   B <= m / (T + t_d),   B_r <= I / (T + t_d)
/// with b, b_r, m, I of the device, T the period, t_d the delay (s). The damping of the coupling is not
/// counted on.
///
/// What the part touches, its mass and the lever from the grip to the contact do not enter (Colgate, Stanley
/// & Brown 1995, "Issues in the haptic display of tool use": b > K T/2 for any passive tool). In six axes,
/// with the springs evaluated at the end of the step, x the device, y the grip and C = diag(K, K_r), a tick
/// without delay generates at most 1/2 dx.C dx - 1/2 dy.C dy beyond what tool and springs lost, and the
/// device dissipates at least dx.D dx / T. So C <= 2 D / T suffices for any y. Contacts only remove motions
/// from y: the hand then feels the springs in series with the rest, C - C P (P^T C P)^-1 P^T C <= C, at a
/// lever r 1 / (1/K + r^2/K_r). See README.md.
///
/// A delay t_d adds K |dx| |dx - dy| t_d / T. The limit covers it while contacts hold the part; a part free
/// to swing against the device adds more, which from a delay of two periods on needs B >= b/4 and B_r >=
/// b_r/4 of the coupling. The limits of B and B_r keep a damper made of differences of readings within one
/// radian of phase at its crossover.
CouplingGains stiffestGrasp(const DeviceLimits& device, double dt, double delay);

}  // namespace tandem::haptics
