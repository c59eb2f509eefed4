#pragma once

// How far a contact that is dragged along a surface stays on that surface: from triangle to triangle, over
// seams, up to the first crease. The proxy's sweep tells what stands in the way; this tells where the ground
// ends.

#include "haptics/scene/contact_world.h"

namespace tandem::haptics {

struct SurfaceWalk {
  double share = 1.0;                  // of the way, 0..1, up to which there is ground under the contact
  SurfacePoint arrival;                // part and triangle under the contact there; nothing else is filled
  std::uint32_t beyond = kNoTriangle;  // of the same part, behind the crease at which the ground ends
  bool sharp = false;  // the contact is on a crease already: its normal is none of the triangle's
};

/// Follows `way` (world, m) from a contact point. Faces turned by more than 10 degrees against the contact's
/// normal end the ground; so do gaps wider than `skin` and a fixed number of triangles. Costs some 20 ns a
/// triangle where the mesh knows its neighbours, a query where it does not (seams between parts, faces that
/// share no vertices).
SurfaceWalk walkSurface(const ContactWorld& world, const SurfacePoint& from, const glm::dvec3& way,
                        double skin);

}  // namespace tandem::haptics
