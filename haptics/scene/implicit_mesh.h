#pragma once

// Implicit shapes (KHR_implicit_shapes) as triangles for contact: flat ones are exact, round ones are
// approximated.

#include <span>

#include "assets/scene/scene.h"

namespace tandem::haptics {

/// One mesh, in the part's frame, for all implicit shapes of a part. Only what contact reads is filled:
/// positions, triangles, triangleMaterial, bounds. Boxes and planes are exact. Spheres, capsules, cylinders
/// and cones have vertices on the surface and facets at most 1e-4 of the radius below it. An infinite plane
/// extends `reach` m each way.
assets::Mesh meshOfShapes(std::span<const assets::ImplicitShape> shapes, double reach);

}  // namespace tandem::haptics
