#pragma once

// How fine the smallest cells of a field have to be, judged by the mesh before anything is baked.

#include "assets/scene/scene.h"

namespace tandem::haptics {

/// The largest side of a cell, m, with which affine models are within `tolerance` (m) of all but a twentieth of the
/// surface: over a ball of radius r about the cell a surface of curvature k is off its best plane by k r^2 / 4.
/// Curvature is how much neighbours turn across edges of less than 20 degrees; flat surfaces need no cells.
/// Infinite where no side is too large.
double cellForCurves(const assets::Mesh& mesh, double tolerance);

}  // namespace tandem::haptics
