#pragma once

// Surface walk: how far a dragged contact stays on its surface, from triangle to triangle and over seams, up
// to the first crease. The proxy's sweep finds obstacles; the walk finds where the surface under the contact
// ends.

#include "haptics/scene/contact_world.h"

namespace tandem::haptics {

struct SurfaceWalk {
  double share = 1.0;                  // fraction of the displacement, 0..1, with surface under the contact
  SurfacePoint arrival;                // part and triangle under the contact there; nothing else is filled
  std::uint32_t beyond = kNoTriangle;  // of the same part, behind the crease at which the surface ends
  bool sharp = false;                  // the contact is on a crease already: its normal is not the triangle's
  bool rises = false;                  // a point ends here between its triangle and `arrival`, which rises
};

/// How exactly a walk ends, m.
struct WalkTolerance {
  double edge = 0.0;  // a path that ends less than twice this beyond an edge does not cross it
  double seam = 0.0;  // gaps of up to twice this are crossed, and steps of up to half of it
};

/// Follows `displacement` (m, world) from a contact point. The surface ends at faces turned by more
/// than 10 degrees against the contact's normal, at wider gaps than tolerated, and after a fixed number of
/// triangles. Costs some 20 ns a triangle where the mesh knows its neighbours, and a query at seams between
/// parts or between faces that share no vertices.
SurfaceWalk walkSurface(const ContactWorld& world, const SurfacePoint& from, const glm::dvec3& displacement,
                        const WalkTolerance& tolerance);

}  // namespace tandem::haptics
