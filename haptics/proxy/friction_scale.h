#pragma once

// Where on a surface the friction is more or less than its material's.

#include "haptics/scene/contact_world.h"

namespace tandem::haptics {

/// What relief with a friction map makes of the coefficients at a place; 1 elsewhere.
double textureFriction(const ContactWorld& world, const SurfacePoint& at);

/// Factor on both friction coefficients at one point of a surface, >= 0. Scenes without surfaces pay one
/// comparison.
inline double frictionScale(const ContactWorld& world, const SurfacePoint& at) {
  return world.surfaces() == nullptr ? 1.0 : textureFriction(world, at);
}

}  // namespace tandem::haptics
