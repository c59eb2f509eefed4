#pragma once

// Recognises the fits of equal radii that loading has given room (round_faces.h), for answers about distance:
// by the file such parts touch.

#include <glm/vec3.hpp>

#include "assets/base/pose.h"
#include "assets/mesh/cylinders.h"
#include "assets/scene/scene.h"

namespace tandem::assets {

/// Whether loading has given any fit of the scene room.
bool hasEqualFits(const Scene& scene);

/// m, the widest gap that such a fit leaves at rest between two parts.
double widestEqualFit(const Scene& scene, PartId a, PartId b);

/// Whether a place of the world lies between a shaft of one part and a bore of the other that have one
/// radius, where both stand in each other. O(triangles of both).
bool isInEqualFit(const Scene& scene, PartId a, const Pose& worldFromA, PartId b, const Pose& worldFromB,
                  const glm::dvec3& place);

/// m, the radius that the file states of a cylinder of a part: of a bore to which loading has given room that
/// of the shaft which fits, else its own. O(triangles of all meshes with such fits).
double statedRadius(const Scene& scene, PartId part, const Cylinder& cylinder);

}  // namespace tandem::assets
