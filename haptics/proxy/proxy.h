#pragma once

// The proxy (god object) of a point or ball tool: it follows the device but never enters a part.
//
// The god object is Zilles & Salisbury 1995, "A constraint-based god-object method for haptic display"; the
// ball proxy is Ruspini, Kolarov & Khatib 1997, "The haptic display of complex graphical environments". Here
// all constraints act in the same tick.
//
// 1. The proxy moves only along segments that a swept test has found free, so it cannot pass an edge, a
//    corner or a thin plate at any speed. A point is a ball of radius 0.
// 2. The proxy rests at radius + margin from a surface and is stopped at radius + margin/2. The margin of a
//    ball is the skin, some 1e-9 of the part's size; that of a point is some 1e-6 of it, so that it passes no
//    crack that rounding has left (ContactWorld::skin, margin), and is subtracted from its depth. Every
//    tolerance is a fraction of either; the code contains no absolute lengths.
// 3. Both sides of every triangle are solid; the orientation of triangles does not matter.

#include <cstdint>
#include <optional>

#include "haptics/base/fixed_vector.h"
#include "haptics/geometry/plane_projection.h"
#include "haptics/scene/contact_world.h"

namespace tandem::haptics {

/// A triangle that the proxy touches, as a constraint plane; world frame.
struct ProxyPlane {
  SurfacePoint surface;     // distance is from the proxy, along the normal
  double skin = 0.0;        // m
  double margin = 0.0;      // m, >= skin: the proxy rests this much further off than its radius
  double multiplier = 0.0;  // m, >= 0: Lagrange multiplier, by which the plane holds the proxy back
  double depth = 0.0;       // m, >= 0: what the hand feels of it, with a skin in place of the margin
  bool arriving = false;    // not touched yet: the face onto which the proxy is being dragged
  bool beyondEdge = false;  // the plane of a face whose edge the tool still touches
};

/// The state of the proxy that persists from tick to tick.
struct Proxy {
  glm::dvec3 position{0.0, 0.0, 0.0};
  FixedVector<ProxyPlane, kMaxPlanes> planes;
  bool sliding = false;  // the goal has left the friction cone and not entered it again
  int sweeps = 0;        // swept tests of the last move
  // Length of the last move relative to its first tangent, >= 1. On a convex curve the proxy travels further
  // than the tangent step, and the next move starts with this factor.
  double stretch = 1.0;
  std::optional<glm::dvec3> goal;  // of the last move, m, unless the ground has changed since
  int rounds = 0;                  // that the present or last move may take
  int late = 0;                    // moves one after another that ended before the proxy had arrived
  // The triangle on which the tool pressed last. A move back to a surface that was just lost is tested
  // against this triangle first, which bounds the sweep over all others.
  PartId lastPart = kNoPart;
  std::uint32_t lastTriangle = kNoTriangle;
};

/// Moves the proxy as near to the goal as the parts allow: constrained minimisation of the distance to the
/// goal (god object). Work is bounded: 24 rounds of at most four sweeps. Over triangles that are small
/// against the depth a point whose goal has gone over few of them has eight, and one more for every two moves
/// in a row that ended too early. Sliding on costs one sweep and resting none; a face that holds
/// the proxy beyond its own edge costs a few, because that edge is tried again each tick. The Coulomb
/// friction of the touched materials holds by the friction cone (Harwin & Melder 2002). The proxy stays while
/// the goal lies in the cone of the static coefficient; otherwise it is dragged along on the cone of the
/// dynamic one. A sticking proxy keeps its position to the bit and costs no sweep; a proxy dragged over a
/// curved surface may take up to four such moves.
void moveProxy(const ContactWorld& world, const glm::dvec3& goal, double radius, Proxy& proxy);

/// Moves the proxy along with a part that has moved from `before` to its present pose. The part carries the
/// proxy rigidly if friction sticks the two together, and otherwise pushes it where it meets it. Returns
/// false if another part stops the proxy, which is then squeezed and may overlap the moved part.
bool pushProxy(const ContactWorld& world, PartId part, const Pose& before, double radius, Proxy& proxy);

/// Whether a plane holds the proxy back now.
inline bool presses(const ProxyPlane& plane) { return plane.multiplier > 0.0; }
/// Whether the hand feels it: a plane holds a point back before the device has reached the surface.
inline bool isFelt(const ProxyPlane& plane) { return plane.depth > 0.0; }

/// How far the margins of what a point touches hold it back before the hand feels anything, m, world.
inline glm::dvec3 heldByMargins(const Proxy& proxy) {
  glm::dvec3 back(0.0);
  for (const ProxyPlane& plane : proxy.planes) {
    if (plane.multiplier != plane.depth) back += (plane.multiplier - plane.depth) * plane.surface.normal;
  }
  return back;
}

/// Where the hand feels a tool of `radius`, m, world: a skin off what it touches, and at the device where the
/// surface is not reached yet.
glm::dvec3 feltPosition(const Proxy& proxy, double radius);

}  // namespace tandem::haptics
