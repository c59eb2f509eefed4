#pragma once

// Dynamics of a control along its one free axis: potential, dry friction, stops.
//
//   m q'' = F - U'(q) - c q' - friction,    U(q) = k (q - rest)^2 / 2 + detents(q) + click(q)
//
// m is a mass and F a force for a sliding control, an inertia and a torque for a turning one.

#include "assets/scene/control.h"

namespace tandem::haptics {

/// Load on a control in one step, linearised about the present state: F(q, v) = force - stiffness (q - q_now)
/// - damping (v - v_now). Units are N, N/m, N·s/m, or N·m, N·m/rad, N·m·s/rad for a dial.
struct AxisLoad {
  double force = 0.0;
  double stiffness = 0.0;
  double damping = 0.0;
};

/// Value (m or rad) and its rate of change.
struct ControlState {
  double value = 0.0;
  double rate = 0.0;
};

/// U'(q): the push that holds the control at q, N or N·m. Detents are wells of equal depth:
///   U' = F sin(2 pi s / w) while |s| < w/2, else 0,       s = q - nearest well, w = min(width, gap);
/// the click adds
///   U' = drop (1 + cos(pi (q - at) / width)) / 2 while |q - at| < width.
double resistance(const assets::Control& control, double value);

/// U(q), J: the work against resistance() from `control.min` to q.
double storedEnergy(const assets::Control& control, double value);

/// An upper bound of |U''| without the spring's, N/m or N·m/rad. Visits all detents: compute it once and keep
/// it.
double steepestResistance(const assets::Control& control);

/// The share of the detents in resistance(), and in its slope, for a control between stops (not endless).
double detentResistance(const assets::Detents& detents, double value);
double steepestDetent(const assets::Detents& detents);

/// Substeps of a tick. The bound L below costs a drag of up to L dt; an eighth of it is below what a hand
/// perceives.
inline constexpr int kControlSubsteps = 8;

/// Advances a control by dt (s), in equal substeps. `steepest` is steepestResistance(control).
///
/// With L = steepest + k + the load's stiffness, an upper bound of the curvature of the whole potential, the
/// end of the step solves
///   m (v' - v) = dt (F - U'(q) - L dt v' - c v' - B (v' - v)) - friction impulse,     q' = q + dt v'.
/// A potential with curvature up to L lies below its parabola, U(q') <= U(q) + U'(q) d + L d^2 / 2 with d =
/// dt v'. So the energy v'^2 m/2 + U of each step is at most that of the step before, for every dt, m and
/// depth of detents. This is the convexity splitting of Eyre 1998, "Unconditionally gradient stable time
/// marching", for a second-order system, with L in place of the convex part. Dry friction is exact within the
/// step: it stops the motion or subtracts its full force. Stops are inelastic.
void stepControl(const assets::Control& control, double steepest, const AxisLoad& load, double dt,
                 ControlState& state);

/// The outcome of one implicit step of dt seconds of a control that parts may push: the rate at its end, m/s
/// or rad/s, and the inertia by which an impulse of those parts changes this rate, kg or kg·m^2. Stops and
/// dry friction are left to the contact (haptics/contact, axis_rows.h). The equation is that of a step of
/// stepControl(), so it gains no energy either; its drag is up to L dt, L as there.
struct GuidedRate {
  double rate = 0.0, inertia = 0.0;
};
GuidedRate guidedRate(const assets::Control& control, double steepest, const AxisLoad& load, double dt,
                      const ControlState& state);

}  // namespace tandem::haptics
