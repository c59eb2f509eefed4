#pragma once

// Friction maps: where on a surface friction differs from that of its material.

#include "haptics/scene/contact_world.h"

namespace tandem::haptics {

/// Factor that a relief texture with a friction map applies to the coefficients at a place; 1 elsewhere.
double textureFriction(const ContactWorld& world, const SurfacePoint& at);

/// Factor on both friction coefficients at one point of a surface, >= 0. Scenes without surfaces pay for one
/// comparison.
inline double frictionScale(const ContactWorld& world, const SurfacePoint& at) {
  return world.surfaces() == nullptr ? 1.0 : textureFriction(world, at);
}

}  // namespace tandem::haptics
