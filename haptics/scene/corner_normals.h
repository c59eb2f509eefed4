#pragma once

// The normals that force shading interpolates: which edges are smooth, and how the surface stands at each
// corner.
//
// 1. Under a crease angle an edge is smooth that turns by less, and normals are estimated from the vertices
//    around a corner: of a quadric through them (exact for spheres, cylinders and cones), where the vertices
//    lie on one; else by Max 1999, "Weights for computing vertex normals from facet normals".
// 2. Where the file's normals are felt, an edge is smooth across which they agree, and they are the normals.
// 3. The apex of a cone has no normal. It shows in facets that turn about a corner but not away from it.

#include <span>

#include "assets/scene/scene.h"
#include "haptics/scene/force_shading.h"

namespace tandem::haptics {

inline constexpr double kFileNormals = -1.0;  // in place of a crease angle: Mesh::triangleNormal

/// `creaseOf`: one angle a material, rad; 0 = flat facets. O(T log T).
ShadedMesh shadeMesh(const assets::Mesh& mesh, std::span<const double> creaseOf);

}  // namespace tandem::haptics
