#pragma once

// Estimates how far flat triangles may be off the curved surface that they represent, from the triangles
// alone.

#include <cstdint>

#include "assets/scene/scene.h"

namespace tandem::client {

/// The sag of one triangle, m, from the angles to its neighbours across edges that are not sharp: a chord of
/// length c whose tangents turn by t lies c/2 tan(t/4) under its arc. 0 where the mesh has no adjacency.
double facetSag(const assets::Mesh& mesh, std::uint32_t triangle);

/// The largest of all triangles, m.
double facetSag(const assets::Mesh& mesh);

}  // namespace tandem::client
