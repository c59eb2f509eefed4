#pragma once

// The spring and damper between the device and what it holds, and how stiff such a spring may be.

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

#include "assets/pose.h"
#include "haptics/device.h"

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

}  // namespace tandem::haptics
