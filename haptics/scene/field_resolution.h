#pragma once

// Cell size that a field needs, estimated from the mesh before anything is baked.

#include "assets/scene/scene.h"

namespace tandem::haptics {

/// The largest side of a cell, m, with which affine models are within `tolerance` (m) on all but a twentieth
/// of the surface: over a ball of radius r about the cell, a surface of curvature k deviates from its best
/// plane by k r^2 / 4. Curvature is the turn between neighbours across edges of less than 20 degrees; flat
/// surfaces need no cells. Infinite if any side suffices.
double cellForCurves(const assets::Mesh& mesh, double tolerance);

}  // namespace tandem::haptics
