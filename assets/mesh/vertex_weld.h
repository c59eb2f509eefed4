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

/// Joins vertices that lie within four times `rounding` (m, along each axis), by which two points may differ
/// that are one before each was rounded twice. A rounding of 0 stands for half a unit in the last place of a
/// single-precision number as large as the largest coordinate: the tolerance then is a share of the
/// coordinates, so a scaled mesh is welded alike. Positions must be finite. O(V) expected, deterministic.
WeldedVertices weldVertices(const std::vector<glm::dvec3>& positions,
                            const std::vector<std::array<std::uint32_t, 3>>& triangles,
                            double rounding = 0.0);

}  // namespace tandem::assets
