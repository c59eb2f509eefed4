#pragma once

// The edge or corner that a contact lies on, and how far a ball can roll about it: on an arc, to the face or
// edge ahead.

#include <cstdint>
#include <numbers>

#include "haptics/scene/contact_world.h"

namespace tandem::haptics {

/// The edge a-b, or the corner a = b, of a contact's triangle that the contact lies on; world frame.
struct Crease {
  glm::dvec3 a, b;
};

Crease creaseUnder(const ContactWorld& world, const SurfacePoint& contact, double skin);

/// How much of a way leads across a crease rather than along it, m.
double wayOver(const Crease& crease, const glm::dvec3& way);

/// How far a ball that rests on a crease can roll before its contact leaves that crease.
struct RollLimit {
  double turn = std::numbers::pi;        // rad
  std::uint32_t triangle = kNoTriangle;  // on which the contact then lies; none if the mesh does not tell
};

/// Around the crease under a contact, from its normal towards `tangent`, a unit vector. A ball with the
/// contact q and the normal m stays on q while m . (v - q) <= 0 for every corner v of the triangles that meet
/// there. Sees at most 24 triangles: of a corner with more, as the fan of a cap has, only the first.
RollLimit rollLimit(const ContactWorld& world, const SurfacePoint& contact, double skin,
                    const glm::dvec3& tangent);

}  // namespace tandem::haptics
