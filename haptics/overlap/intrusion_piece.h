#pragma once

// Pieces of a mesh's triangles in a solid, and how to cut them. Used by mesh_intrusion.

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "haptics/geometry/triangle_bvh.h"

namespace tandem::haptics {

/// A point of the mesh, and the facet of the solid nearest to it.
struct Place {
  glm::dvec3 point;  // m, solid frame
  /// On its triangle: corner 0 + x (corner 1 - corner 0) + y (corner 2 - corner 0).
  glm::dvec2 shares;
  double distance = -1.0;  // m; negative: not measured
  std::uint32_t facet = 0;
};

/// A segment of a triangle in which the solid's surface crosses it, in shares as in Place.
struct Crossing {
  glm::dvec2 from, to;
};

/// A piece of a triangle, with an upper bound of the depth of its points.
struct Piece {
  double bound = 0.0;       // m
  std::uint64_t order = 0;  // breaks ties between equal bounds
  std::array<Place, 3> corners;
  glm::dvec3 peak{0.0, 0.0, 0.0};        // shares of the corners: where the bound occurs
  std::uint32_t extra = kNoTriangle;     // one more facet to bound with
  bool untouched = false;                // of a triangle that no surface and no lid comes near
  bool inside = false;                   // known to be inside, wholly once nothing crosses it
  int flush = 0;                         // halvings since it was found to touch everywhere
  std::vector<std::uint32_t> crossings;  // into the search's list

  bool operator<(const Piece& other) const {
    return bound != other.bound ? bound < other.bound : order > other.order;
  }
  /// A part of it with other corners, and without its crossings.
  Piece part(const Place& a, const Place& b, const Place& c) const {
    Piece part;
    part.bound = bound;
    part.corners = {a, b, c};
    part.extra = extra;
    part.untouched = untouched;
    part.inside = inside;
    part.flush = flush;
    return part;
  }
  /// A place of it, given the shares of its corners; measured only if it is a corner.
  Place at(const glm::dvec3& cornerShares) const;
  double side(std::size_t i) const { return glm::length(corners[(i + 1) % 3].point - corners[i].point); }
  double longest() const { return std::max({side(0), side(1), side(2)}); }
};

/// The segment in which two triangles meet, on the first one; nothing if it is a point or less.
std::optional<Crossing> crossingOf(const Triangle& own, const Triangle& other);

/// The share of a crossing's length that lies within a piece, its borders excluded.
double shareWithin(const Crossing& crossing, const Piece& piece);

/// Signed heights of a piece's corners over a line, in which a cut along the line is made.
using Heights = std::array<double, 3>;
Heights heightsOver(const Crossing& line, const Piece& piece);

/// Heights over the plane through that side of a facet, upright on it, which divides the piece best (the
/// Voronoi subdivision of Tang et al. 2009): above one facet the distance is linear. Nothing if the facet is
/// small beside the piece, or hardly divides it.
std::optional<Heights> heightsOverSide(const Triangle& facet, const Piece& piece);

}  // namespace tandem::haptics
