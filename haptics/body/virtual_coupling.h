#pragma once

// The spring and damper between the device and what it holds, and how stiff such a spring may be.

#include <array>
#include <span>

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

#include "assets/base/pose.h"
#include "haptics/base/device.h"

namespace tandem::haptics {

/// Gains of a six-axis coupling.
struct CouplingGains {
  double stiffness = 0.0;     // N/m
  double damping = 0.0;       // N·s/m
  double rotStiffness = 0.0;  // N·m/rad
  double rotDamping = 0.0;    // N·m·s/rad
};

/// A rigid body for integration: pose and twist of its part frame, mass about the centre of mass.
struct RigidBody {
  double mass = 1.0;                       // kg, > 0
  glm::dvec3 centreOfMass{0.0, 0.0, 0.0};  // m, body frame
  glm::dmat3 inertia{1.0};                 // kg·m^2, about the centre of mass, body axes, positive definite
  Pose worldFromBody;
  Twist twist;  // of the body frame's origin
};

inline constexpr int kMostCouplings =
    4;  // on one body: two hands, or one and a tool; its links; what leads it

/// A coupling from a grip on a body to a device.
struct Coupling {
  Pose bodyFromGrip, worldFromDevice;
  Twist device;
  CouplingGains gains;
};

/// What a coupling gives in one step.
struct CouplingForce {
  glm::dvec3 arm{0.0, 0.0, 0.0};     // m, from the centre of mass to the grip
  glm::dvec3 force{0.0, 0.0, 0.0};   // N, of the coupling if the body stood still
  glm::dvec3 torque{0.0, 0.0, 0.0};  // N·m
  double drag = 0.0, rotDrag = 0.0;  // B + T K

  /// What the coupling puts on the hand when the body has moved with this velocity and spin.
  Wrench onHand(const glm::dvec3& velocity, const glm::dvec3& spin) const {
    return {drag * (velocity + glm::cross(spin, arm)) - force, rotDrag * spin - torque};
  }
};

/// One step of a coupled body before anything stands in its way:
///     A (v - v_free) = what contacts give, N·s,     A = M + T sum_i G_i^T (B_i + T K_i) G_i
/// v = (velocity of the centre of mass, spin), world axes.
struct CoupledStep {
  std::array<std::array<double, 6>, 6> root{};  // L, lower triangle, A = L L^T; kg, kg·m, kg·m^2
  glm::dvec3 freeVelocity{0.0, 0.0, 0.0};       // m/s
  glm::dvec3 freeSpin{0.0, 0.0, 0.0};           // rad/s
  std::array<CouplingForce, kMostCouplings> couplings;
};

/// The step of a body that is drawn by couplings (at most kMostCouplings) from grip frames to those of devices, by
/// `load` about its centre of mass and by `acceleration` (m/s^2, gravity); the rest as of stepCoupledBody().
CoupledStep coupleBody(const RigidBody& body, std::span<const Coupling> couplings, const Wrench& load,
                       const glm::dvec3& acceleration, double dt);

/// The step of a body that nothing draws: it keeps `share` (0..1) of its velocity.
CoupledStep coast(const RigidBody& body, double share);

/// Gives a body this velocity of its centre of mass and this spin, where it is.
void setVelocity(RigidBody& body, const glm::dvec3& velocity, const glm::dvec3& spin);

/// Moves a body by dt with this velocity of its centre of mass and this spin.
void moveBody(RigidBody& body, const glm::dvec3& velocity, const glm::dvec3& spin, double dt);

/// Advances a body by dt (s), drawn by the coupling from its grip frame to the device's and by `acceleration`
/// (m/s^2, gravity). Returns the wrench that the coupling puts on the hand at the device's tip: the exact
/// reaction to what acts on the body in this step.
///
/// The springs are evaluated at the end of the step (backward Euler, one 6 x 6 solve), as in McNeely,
/// Puterbaugh & Troy 1999 with the integration of Otaduy & Lin 2006, "A modular haptic rendering algorithm
/// for stable and transparent 6-DOF manipulation": any mass, inertia and gain is stable at any dt, at the
/// price of some damping. The gyroscopic torque is left out: at the speeds of a hand it is small, and taken
/// explicitly it could feed energy in.
Wrench stepCoupledBody(RigidBody& body, const Pose& bodyFromGrip, const Pose& worldFromDevice,
                       const Twist& device, const CouplingGains& gains, const glm::dvec3& acceleration,
                       double dt);

/// The stiffest virtual wall that a hand on this device can be promised to be stable, N/m: the lesser of
///   2 b / T                    no energy from holding a position for a tick (Colgate & Brown 1994; Abbott &
///   Okamura 2005
///                              with b the device's damping)
///   (b + B) / (T/2 + t_d)      phase lag of the hold and of the loop's delay (Gil, Sanchez, Hulin, Preusche
///   & Hirzinger
///                              2009, for B well below its own limit)
/// with b the device's physical damping (N·s/m), B the coupling's, T the period and t_d the delay (s).
double stiffestStable(double deviceDamping, double period, double delay, double couplingDamping);

/// The same for a device as it describes itself, with no damping of the coupling's own: what a contact on it
/// may be given by default, N/m. 0 for a device that drives nothing or has no damping of its own to draw on.
double stiffestContact(const DeviceLimits& device, double dt, double delay);

/// The largest gains of the coupling to a held part that the loop through a device keeps passive (K, K_r) and its
/// damper stable (B, B_r); 0 where the device does not drive or state what decides it: nothing closes a loop about an
/// axis without a motor.
///     K <= b / (T/2 + t_d),   K_r <= b_r / (T/2 + t_d),   B <= m / (T + t_d),   B_r <= I / (T + t_d)
/// with b, b_r, m, I of the device, T the period, t_d the delay (s). No damping of the coupling is counted on.
///
/// What the part touches, its mass and the lever from the grip to where it touches do not enter (Colgate, Stanley &
/// Brown 1995, "Issues in the haptic display of tool use": b > K T/2 for any passive tool). In six axes: with the
/// springs evaluated at the end of the step, x the device, y the grip, C = diag(K, K_r), a tick without delay gives
/// out 1/2 dx.C dx - 1/2 dy.C dy more than the tool and the springs lost, and the device takes dx.D dx / T at least:
/// C <= 2 D / T is enough whatever y does. Contacts only take motions from y: the hand feels the springs in series
/// with what is left, C - C P (P^T C P)^-1 P^T C <= C, at a lever r 1 / (1/K + r^2/K_r). See README.md.
///
/// A delay t_d adds K |dx| |dx - dy| t_d / T: as much as is counted while contacts hold the part, more while it is free
/// to swing against the device; from two periods on that needs B >= b/4, B_r >= b_r/4 of the coupling. The limits of
/// B, B_r hold a damper made of differences of readings to one radian of phase where it crosses over.
CouplingGains stiffestGrasp(const DeviceLimits& device, double dt, double delay);

}  // namespace tandem::haptics
