#pragma once

// Exact relations between two triangles, in double precision.

#include "haptics/geometry/triangle_math.h"

namespace tandem::haptics {

/// The nearest points of two triangles.
struct TrianglePairGap {
  double square = 0.0;            // m^2, of the distance; 0 where they meet
  glm::dvec3 onA{0.0, 0.0, 0.0};  // m
  glm::dvec3 onB{0.0, 0.0, 0.0};  // m
};

/// Nearest points of two triangles. Their distance is that of a corner from a triangle or of two edges, or 0
/// where an edge passes through a face (Larsen, Gottschalk, Lin & Manocha 1999, "Fast proximity queries with
/// swept sphere volumes", section 5). Triangles without area are handled as edges and points.
TrianglePairGap nearestPoints(const Triangle& a, const Triangle& b);

/// Whether two triangles come as near as `distance` (m); cheaper than nearestPoints().
bool comeNear(const Triangle& a, const Triangle& b, double distance);

/// A triangle with data for a fast distance bound.
struct Facet {
  Triangle t;
  glm::dvec3 normal;     // unit; 0 where the triangle has no area
  glm::dvec3 low, high;  // m, its box
};
Facet facetOf(const Triangle& t);

/// Whether boxes or one of the planes prove two triangles further apart than `reach` (m), at a twentieth of
/// the cost of their distance. Exact up to the rounding of their coordinates.
bool furtherThan(double reach, const Facet& a, const Facet& b);

/// Where the segment from `from` to `to` goes through the face of `t`, its rim included: the share of the
/// segment. Below 0 where it does not, where it runs along the plane or where the triangle has no area.
double pierceShare(const glm::dvec3& from, const glm::dvec3& to, const Triangle& t);

/// How far two triangles that meet stand through each other, m: the least by which one must move along the
/// normal of either before it is wholly on one side of the other.
double standThrough(const Facet& a, const Facet& b);

}  // namespace tandem::haptics
