#pragma once

// Triangle meshes of implicit shapes (KHR_implicit_shapes) for contact: flat shapes are exact, round ones
// approximated.

#include <span>

#include "assets/scene/scene.h"

namespace tandem::haptics {

/// One mesh, in the part's frame, for all implicit shapes of a part. Only the fields that contact reads are
/// filled: positions, triangles, triangleMaterial, bounds. Boxes and planes are exact. Spheres, capsules,
/// cylinders and cones have vertices on the surface and facets at most 1e-4 of the radius below it. An
/// infinite plane extends `reach` m in each direction.
assets::Mesh meshOfShapes(std::span<const assets::ImplicitShape> shapes, double reach);

}  // namespace tandem::haptics
