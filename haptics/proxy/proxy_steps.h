#pragma once

// How the proxy moves: straight until it is stopped, over a crease, or off a ridge.

#include <glm/vec3.hpp>

#include "haptics/proxy/proxy.h"
#include "haptics/scene/contact_world.h"

namespace tandem::haptics {

/// Moves along a straight way, m, until a part stops it; true if none did.
bool advance(const ContactWorld& world, const glm::dvec3& way, double radius, Proxy& proxy);

/// Rolls the ball over the crease that it presses on alone, towards the place over it that is nearest to the
/// goal: up to the face or edge ahead, or by kMaxRoll, along two tangents of the arc. False if it is there.
bool rollOverCrease(const ContactWorld& world, const glm::dvec3& goal, double radius, const glm::dvec3& way,
                    int index, Proxy& proxy);

/// Lets a point that rests on a ridge rest on the face that its way leads onto. False if the mesh does not
/// tell.
bool stepOffRidge(const ContactWorld& world, const glm::dvec3& position, const glm::dvec3& way,
                  ProxyPlane& plane);

}  // namespace tandem::haptics
