#pragma once

// Facets of a body, with the normals of its surfaces.

#include <cstddef>

#include "assets/cad_import/cad_scene.h"
#include "assets/cad_import/step_tree.h"

namespace tandem::cad_import {

/// What facets deviate from the body's surfaces, mm: what is asked, or a thousandth of the body's diagonal.
double deflectionOf(const Body& body, double asked);

/// The body's mesh, its lengths in m by `metresPerMillimetre`. Facets that the faces have already are kept.
/// Adds to `lost` the faces that could not be meshed.
CadMesh meshBody(const Body& body, double deflection, double metresPerMillimetre, std::size_t& lost);

}  // namespace tandem::cad_import
