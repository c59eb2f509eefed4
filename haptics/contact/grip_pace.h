#pragma once

// How a part in a hand slips. Contact keeps a part from where its hand's spring pulls it. Where that contact
// ends, at an edge or as a jam opens, a light part would be at full speed within a millisecond, and would
// stand still within another where it arrives: two kicks. So while a part slips, the place where the hand
// holds it goes hardly faster than the hand, and changes its direction as gently: only a share of each step
// is taken.
//
// This can only dissipate energy. Let T be the period, x the pose, and E the potential energy of springs and
// weight, convex while rotations are small. A step of backward Euler from the velocity v0 minimizes
// 1/2 |v - v0|^2 + E(x + T v), with |.| the norm by mass, over the velocities v that contacts allow. v = 0 is
// one of them, so the minimum obeys 1/2 |v|^2 + E(x + T v) <= 1/2 |v0|^2 + E(x). For a share s, 0..1:
//     1/2 |s v|^2 + E(x + s T v) <= s (1/2 |v|^2 + E(x + T v)) + (1 - s) E(x) <= 1/2 |v0|^2 + E(x).

#include <glm/vec3.hpp>

#include "haptics/solver/step_space.h"

namespace tandem::haptics {

/// How far the grip, the place where a hand holds a part, may go in a tick: to within `farthest` of where it
/// was when the tick began, and to within `aside` of `steady`.
struct GripPace {
  glm::dvec3 arm{0.0, 0.0, 0.0};       // m, world, from the part's centre of mass to the grip
  glm::dvec3 steady{0.0, 0.0, 0.0};    // m, world: the displacement of the grip that keeps the force
  double aside = 0.0, farthest = 0.0;  // m
};

/// What decides a pace.
struct GripMotion {
  glm::dvec3 arm{0.0, 0.0, 0.0};         // m, world, from the part's centre of mass to the grip
  glm::dvec3 lastOnHand{0.0, 0.0, 0.0};  // N, of the coupling's spring in the last tick
  glm::dvec3 spring{0.0, 0.0, 0.0};      // N, of that spring on the part if it stood still
  double stiffness = 0.0;                // N/m, of the spring
  double gripWay = 0.0, handWay = 0.0;   // m, that the grip and the hand go in a tick
};

/// The pace of a grip in a tick. A slip may change the spring's force by `force` (N, > 0) in a tick, beyond
/// what the hand's own motion does.
GripPace paceOf(const GripMotion& motion, double force);

/// The largest share, 0..1, of the displacement `next` of a part that keeps the pace after it has been
/// displaced by `done` in the same tick, or comes as near to that as any. `pushed`: m that others may move
/// the part in the tick.
double shareWithin(const GripPace& pace, const Displacement& done, const Displacement& next, double pushed);

}  // namespace tandem::haptics
