#pragma once

// Friction maps: where on a surface friction differs from that of its material.

#include "haptics/scene/contact_world.h"

namespace tandem::haptics {

/// Factor that a relief texture with a friction map applies to the coefficients at a place (m, part frame) of
/// one triangle; 1 elsewhere.
double textureFriction(const ContactWorld& world, PartId part, std::uint32_t triangle,
                       const glm::dvec3& place);

/// Factor on both friction coefficients at one point of a surface, >= 0. Scenes without surfaces pay for one
/// comparison.
inline double frictionScale(const ContactWorld& world, const SurfacePoint& at) {
  if (world.surfaces() == nullptr) return 1.0;
  return textureFriction(world, at.part, at.triangle, transformPoint(inverse(world.pose(at.part)), at.point));
}

}  // namespace tandem::haptics
