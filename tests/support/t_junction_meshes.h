#pragma once

// Meshes with T-junctions, made from clean ones: edges are cut on one side, or on both sides at other places,
// as a program leaves them that tessellates every face by itself.

#include <cstdint>

#include <glm/mat3x3.hpp>

#include "assets/mesh/mesh_analysis.h"

namespace tandem::test {

/// Which edges are cut, and where.
struct EdgeCuts {
  std::uint32_t seed = 0;
  double share = 0.5;      // of the edges of two triangles
  int most = 3;            // vertices on one side of an edge
  bool bothSides = false;  // the two sides of an edge are cut at places of their own
  bool crowded = false;    // the vertices of one side stand within a thousandth of the edge
};

/// The same surface with every triangle cut at new vertices on its edges. `clean` may have corners of its own
/// for each triangle; edges are known by the places of their ends. New vertices are exact to doubles.
assets::TriangleSoup withTJunctions(const assets::TriangleSoup& clean, const EdgeCuts& cuts);

/// Moves a soup: p becomes turn * (scale * p) + shift.
assets::TriangleSoup placed(assets::TriangleSoup soup, const glm::dmat3& turn, double scale,
                            const glm::dvec3& shift);

/// The coordinates rounded to single precision.
assets::TriangleSoup roundedToFloat(assets::TriangleSoup soup);

/// Any rotation, by its seed.
glm::dmat3 turnOf(std::uint32_t seed);

/// Two rectangles side by side in the plane z = 0, normal +z, with their common edge on the x axis from
/// -size / 2 to size / 2: `below` columns at y < 0 and `above` at y > 0, which are `rows` rows deep. Where
/// `seed` is not 0 the columns are of different widths.
assets::TriangleSoup twoStrips(double size, int below, int above, int rows, std::uint32_t seed = 0);

}  // namespace tandem::test
