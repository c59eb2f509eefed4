#pragma once

// How far flat triangles may be off the curved surface that they stand for, judging by the triangles alone.

#include <cstdint>

#include "assets/scene/scene.h"

namespace tandem::client {

/// Of one triangle, m, judging by how much its neighbours turn across edges that are not sharp: a chord of
/// length c whose tangents turn by t lies c/2 tan(t/4) under its arc. 0 where the mesh does not know its
/// neighbours.
double facetSag(const assets::Mesh& mesh, std::uint32_t triangle);

/// The largest of all triangles, m.
double facetSag(const assets::Mesh& mesh);

}  // namespace tandem::client
