#pragma once

// Steps of the proxy: straight until a part stops it, over a crease, or off a ridge.

#include <glm/vec3.hpp>

#include "haptics/proxy/proxy.h"
#include "haptics/scene/contact_world.h"

namespace tandem::haptics {

/// Moves along a straight displacement, m, until a part stops the proxy; true if none did.
bool advance(const ContactWorld& world, const glm::dvec3& displacement, double radius, Proxy& proxy);

/// Rolls the ball over the crease of the proxy's plane `pressing`, which alone presses on it, towards the
/// point above the crease nearest to the goal. The roll ends at the next face or edge or after kMaxRoll,
/// and follows two tangents of the arc. False if the ball is already there.
bool rollOverCrease(const ContactWorld& world, const glm::dvec3& goal, double radius,
                    const glm::dvec3& displacement, ProxyPlane& pressing, Proxy& proxy);

/// Moves the contact of a point that rests on a ridge onto the face that its displacement leads over. False
/// if the mesh does not know its neighbours.
bool stepOffRidge(const ContactWorld& world, const glm::dvec3& position, const glm::dvec3& displacement,
                  ProxyPlane& plane);

}  // namespace tandem::haptics
