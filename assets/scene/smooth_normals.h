#pragma once

// The normals that a file states for its vertices, made fit to be felt.

#include <cstdint>

#include <glm/vec3.hpp>

#include "assets/scene/scene.h"

namespace tandem::assets {

/// Whether two normals on the two sides of an edge, at one of its ends, are those of one smooth surface.
/// `facetA`, `facetB` are the unit normals of the facets. 1e-3 rad apart, or a tenth of the facets' own turn
/// up to 0.02 rad.
bool agreeAcross(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& facetA,
                 const glm::dvec3& facetB);

/// Brings Mesh::triangleNormal to length 1 and to the facets' side; a corner without a normal, or with one
/// more than 40 degrees off, takes its facet's. Empties it where no edge turns whose normals agree: there
/// they say no more than the facets.
void settleNormals(Mesh& mesh);

/// Triangles of a material with a normal that is not the facet's.
std::uint64_t smoothTriangles(const Mesh& mesh, std::uint16_t material);

/// Forgets the normals: the scene's surfaces are their facets where no crease angle says otherwise.
void dropNormals(Scene& scene);

}  // namespace tandem::assets
