#pragma once

// Finds the vertices of a file that are one point, so that faces which touch also share their corners.

#include <array>
#include <cstdint>
#include <vector>

#include <glm/vec3.hpp>

namespace tandem::assets {

/// The distinct points among some vertices.
struct WeldedVertices {
  std::vector<std::uint32_t> pointOf;  // V: index into points, or kNone for a vertex that no triangle uses
  std::vector<glm::dvec3> points;      // m, in the order of first use
  double tolerance = 0.0;              // m, largest coordinate difference of two welded vertices
};

/// Joins vertices that lie within about two units in the last place of the largest single-precision
/// coordinate, which a file of floats cannot distinguish. The tolerance is a share of the coordinates, so a
/// scaled mesh is welded alike. Positions must be finite. O(V) expected, deterministic.
WeldedVertices weldVertices(const std::vector<glm::dvec3>& positions,
                            const std::vector<std::array<std::uint32_t, 3>>& triangles);

}  // namespace tandem::assets
