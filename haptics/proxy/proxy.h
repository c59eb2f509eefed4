#pragma once

// The proxy of a point or ball tool: it follows the device, but never enters a part.
//
// Zilles & Salisbury 1995, "A constraint-based god-object method for haptic display"; Ruspini, Kolarov &
// Khatib 1997, "The haptic display of complex graphical environments" (ball proxy). Here all constraints act
// in the same tick.
//
// 1. The proxy moves only along segments that a swept test has found free, so it cannot pass an edge, a
//    corner or a thin plate, whatever the speed. A point is a ball of radius 0.
//
// 2. It rests at radius + skin from a surface and is stopped at radius + skin/2; the skin is some 1e-9 of the
//    part's size (ContactWorld::skin). Every tolerance here is a share of the skin: there are no lengths in
//    the code.
//
// 3. Both sides of every triangle are solid; orientation is never asked.

#include <array>
#include <cstdint>

#include "haptics/geometry/plane_projection.h"
#include "haptics/scene/contact_world.h"

namespace tandem::haptics {

/// A triangle that the proxy touches, as a plane; world frame.
struct ProxyPlane {
  SurfacePoint surface;     // distance: from the proxy, along the normal
  double skin = 0.0;        // m
  double multiplier = 0.0;  // m: how far this plane holds the proxy off the goal, along its normal
  bool arriving = false;    // not touched yet: the ground that the proxy is being dragged onto
  bool beyondEdge = false;  // the plane of a face, counted where the tool is still on its edge
};

/// What the proxy remembers from tick to tick.
struct Proxy {
  glm::dvec3 position{0.0, 0.0, 0.0};
  std::array<ProxyPlane, kMaxPlanes> planes;
  int planeCount = 0;
  bool sliding = false;  // the friction cone was left, and not yet entered again
  int sweeps = 0;        // of the last move: what it cost
  // How much further than its first tangent the last move went: over 1 on a convex curve, whose centre is
  // further from the proxy than the goal is. The next move begins with as much.
  double stretch = 1.0;
  // Where the tool pressed last. A way to the surface that it has just lost is tried against this triangle
  // first: what it cannot reach sooner needs no look.
  PartId lastPart = kNoPart;
  std::uint32_t lastTriangle = kNoTriangle;
};

/// Moves the proxy as near to the goal as the parts let it, without friction: the path of constrained
/// descent. Bounded work: at most 24 rounds of at most four sweeps; one sweep where a tool slides on, none
/// where it rests, a few where a face holds it beyond its own edge, which is tried anew each tick.
void slideProxy(const ContactWorld& world, const glm::dvec3& goal, double radius, Proxy& proxy);

/// slideProxy() with the Coulomb friction of the touched materials (Harwin & Melder 2002, the friction cone:
/// the proxy stays while the goal lies in the cone of the static coefficient, else it is drawn along at that
/// of the dynamic one). A proxy that stays keeps its position to the bit and costs no sweep; one that is
/// drawn over a curved surface may take up to four such moves.
void moveProxy(const ContactWorld& world, const glm::dvec3& goal, double radius, Proxy& proxy);

/// Takes the proxy along with a part that has moved from `before` to its present pose: pushed where the part
/// met it, carried rigidly if it stuck to that part by friction. False if another part stopped it, so that it
/// is squeezed; it then may overlap the part that moved.
bool pushProxy(const ContactWorld& world, PartId part, const Pose& before, double radius, Proxy& proxy);

/// Whether a plane holds the proxy back now.
inline bool presses(const ProxyPlane& plane) { return plane.multiplier > 0.0; }

}  // namespace tandem::haptics
