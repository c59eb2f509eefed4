#pragma once

// Creases: the edge or corner that a contact lies on, and the arc on which a ball can roll about it until it
// reaches the next face or edge.

#include <cstdint>
#include <numbers>

#include "haptics/scene/contact_world.h"

namespace tandem::haptics {

/// The edge a-b, or the corner a = b, of the contact's triangle on which the contact lies; world frame.
struct Crease {
  glm::dvec3 a, b;
};

Crease creaseUnder(const ContactWorld& world, const SurfacePoint& contact, double skin);

/// Length of the component of a displacement that leads across a crease rather than along it, m.
double lengthAcross(const Crease& crease, const glm::dvec3& displacement);

/// How far a ball that rests on a crease can roll before its contact leaves that crease.
struct RollLimit {
  double angle = std::numbers::pi;  // rad
  // The triangle that then carries the contact; kNoTriangle if the mesh does not know its neighbours.
  std::uint32_t triangle = kNoTriangle;
};

/// Roll limit about the crease under a contact, from its normal towards the unit vector `tangent`. A ball
/// with contact q and normal m stays on q while m . (v - q) <= 0 for every corner v of the triangles that
/// meet there. Considers at most 24 triangles; larger fans, such as a cap's, are truncated.
RollLimit rollLimit(const ContactWorld& world, const SurfacePoint& contact, double skin,
                    const glm::dvec3& tangent);

}  // namespace tandem::haptics
