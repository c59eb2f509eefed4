#pragma once

// What touched surfaces add where a part in the hand touches them: relief, vibration, viscosity, stick-slip,
// pop-through. What acts before they are touched is in held_magnets.h.
//
// The contacts of a held part are rigid (haptics/contact), so laws and shading have nothing to act on. Those
// with one surface on one side of a part count as one, at their centre by force; N is their sum, n the
// normal, h the relief.
//   relief      -N grad h across n, on the hand, of a slope of at most 1
//   vibration   along n, on the hand, at most N, as with the bare tool
//   viscosity and stick-slip    -k (s + T v) - c v across n, on the part in the next step; s the slip since
//               the anchor, T the tick
//   pop-through the part passes through once N has been above the surface's force for 20 ms
// 1. Relief gives out no more than it got. An account grows by -F dx of the device, for the share of F that
//    was sent; what a tick would give at twice the last motion is held to the account, and a tick's error is
//    paid back first. The hand gets the force at the device's tip, without its moment: behind the coupling
//    relief of 100 Hz would be weakened.
// 2. Viscosity and springs lose energy at every step. k and c are lowered together until T W (c + k T) <= 1,
//    summed over contacts, W the most that a push there moves the part. With v' = v + T W F, the work on the
//    part and the growth of the springs add up to
//      -T^2 W F^2 (1 - k T^2 W) / 2 - (k T^2 / 2 + c T) v^2 - c T^2 W v F <= 0.
//    They are in series with the hand's coupling, whose limit is the device's. A part that moves here too
//    would not feel the reaction, so on it nothing drags.
// 3. Vibration is the one source.
// 4. Up to kMaxSurfaceContacts contacts act; more are left out. Free of allocation. For scenes with a
//    SurfaceScene only.

#include <array>
#include <span>

#include <glm/mat3x3.hpp>

#include "assets/base/pose.h"
#include "haptics/base/tick_types.h"
#include "haptics/scene/contact_world.h"
#include "haptics/surface/apply_surface.h"
#include "haptics/surface/surface_effects.h"

namespace tandem::haptics {

/// A place where the held part rests on another part.
struct HeldTouch {
  PartId part = kNoPart;             // the other one
  glm::dvec3 point{0.0, 0.0, 0.0};   // m, world
  glm::dvec3 normal{0.0, 0.0, 0.0};  // unit, world, towards the held part
  double force = 0.0;                // N
  bool yields = false;               // the other part moves here too: nothing drags across the normal
};

/// The part in the hand, and the hand.
struct HeldBody {
  Pose worldFromPart;
  Twist twist;
  glm::dvec3 centre{0.0, 0.0, 0.0};     // m, world, of mass
  double mass = 1.0;                    // kg
  glm::dmat3 mobility{0.0};             // 1/(kg·m^2), the inverse inertia about the centre, world axes
  glm::dvec3 handMoved{0.0, 0.0, 0.0};  // m, of the hand since the last tick
  double sentShare = 1.0;               // 0..1, of the force of the last tick that the device got
};

/// What one hand remembers of the surfaces under its part.
struct HeldSurfaces {
  struct Slot {
    PartId part = kNoPart;
    bool active = false;
    glm::dvec3 normal{0.0, 0.0, 0.0};
    glm::dvec3 slip{0.0, 0.0, 0.0};  // m, world, since the anchor
    double stiffness = 0.0;          // N/m, of stick-slip in the last tick
    double phase = 0.0;              // turns, of the vibration
    double pressed = 0.0;            // s, since it has been pressed harder than what it bears
  };
  std::array<Slot, kMaxSurfaceContacts> slots;
  glm::dvec3 relief{0.0, 0.0, 0.0};  // N, on the hand in the last tick
  double account = 0.0;              // J, that the hand has put into relief and not got back
};

/// The forces of one tick.
struct HeldSurfaceForces {
  glm::dvec3 onHand{0.0, 0.0, 0.0};  // N, world
  Wrench onPart;                     // in the next step, about its centre of mass
  PartId givesWay = kNoPart;         // the part passes through this one from now on
};

/// The surface effects of a tick in which the held part has these touches.
HeldSurfaceForces feelThrough(const ContactWorld& world, std::span<const HeldTouch> touches,
                              const HeldBody& body, const TickParameters& parameters, HeldSurfaces& state);

}  // namespace tandem::haptics
