#pragma once

// What a control feels like along its one free axis, and how it moves: potential, dry friction, stops.
//
//   m q'' = F - U'(q) - c q' - friction,    U(q) = k (q - rest)^2 / 2 + detents(q) + click(q)
//
// m is a mass and F a force for a control that slides, an inertia and a torque for one that turns.

#include "assets/scene/control.h"

namespace tandem::haptics {

/// What acts on a control from outside in one step, as it is now and as it would change: F(q, v) = force -
/// stiffness (q - q_now) - damping (v - v_now). N, N/m, N·s/m; for a dial N·m, N·m/rad, N·m·s/rad.
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

/// U'(q): what has to be pushed with to hold the control at q, N or N·m. Detents are wells of equal depth:
///   U' = F sin(2 pi s / w) while |s| < w/2, else 0,       s = q - nearest well, w = min(width, gap);
/// the click adds
///   U' = drop (1 + cos(pi (q - at) / width)) / 2 while |q - at| < width.
double resistance(const assets::Control& control, double value);

/// U(q), J: the work that resistance() has taken from `control.min` on.
double storedEnergy(const assets::Control& control, double value);

/// An upper bound of |U''| but for the spring, N/m or N·m/rad. Walks the detents: computed once, then kept.
double steepestResistance(const assets::Control& control);

/// The part of detents alone in resistance(), and in its slope; between stops, not endless.
double detentResistance(const assets::Detents& detents, double value);
double steepestDetent(const assets::Detents& detents);

/// Steps in a tick. What L below costs is a drag of up to L dt: an eighth of it is less than a hand can tell.
inline constexpr int kControlSubsteps = 8;

/// Advances a control by dt (s), in equal steps. `steepest` is steepestResistance(control).
///
/// With L = steepest + k + the load's stiffness, an upper bound of the curvature of everything that has a
/// potential, the end of the step solves
///   m (v' - v) = dt (F - U'(q) - L dt v' - c v' - B (v' - v)) - friction impulse,     q' = q + dt v'.
/// A potential with curvature up to L lies below its parabola, U(q') <= U(q) + U'(q) d + L d^2 / 2, d = dt
/// v'; so the energy v'^2 m/2 + U of each step is at most that of the one before, for every dt, m and depth
/// of detents (the convexity splitting of Eyre 1998, "Unconditionally gradient stable time marching", for a
/// second order system; L takes the place of its convex part). Dry friction is exact within the step: it
/// stops the motion or takes its full force off. Stops hold without giving back.
void stepControl(const assets::Control& control, double steepest, const AxisLoad& load, double dt,
                 ControlState& state);

}  // namespace tandem::haptics
