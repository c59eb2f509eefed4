#pragma once

// The separating directions of an edge of one body and a corner or edge of another: they lie across the
// edge, between its own normals, and opposite to a normal of the other body.

#include <span>

#include <glm/vec3.hpp>

#include "haptics/geometry/mesh_edges.h"

namespace tandem::haptics {

/// Directions across an edge as angles from its first normal towards the second; rad.
class EdgePlane {
 public:
  explicit EdgePlane(const MeshEdge& edge);
  /// The angle of v, rad, unrolled to within half a turn of the middle of the edge's own directions.
  double angle(const glm::dvec3& v) const;
  /// The length of the part of v that is across the edge.
  double length(const glm::dvec3& v) const;
  glm::dvec3 direction(double angle) const;
  /// The angle of the second normal, rad.
  double end() const { return end_; }
  /// Unit, along the edge.
  const glm::dvec3& along() const { return along_; }

 private:
  glm::dvec3 along_, first_, second_;
  double end_;
};

/// The directions from `low` to `high`, rad; none where high < low.
struct Directions {
  double low = 0.0, high = -1.0;
  bool none() const { return high < low; }
};

/// The directions of the edge that are opposite to a normal of the other body. They are the section of that
/// body's normal cone, which its `normals` (unit) span, with the plane across the edge.
Directions commonDirections(const EdgePlane& plane, std::span<const glm::dvec3> normals);

/// The directions that are nearly opposite: the projection of the normal cone onto that plane, or the end
/// of the edge's own directions that is nearest to it.
Directions nearestDirections(const EdgePlane& plane, std::span<const glm::dvec3> normals);

/// The direction of `shared` in which the predicted offset from the edge is longest, with the present offset
/// not below -slack m where that is possible: a corner that is slightly over the rim must move back by that
/// much, not climb around the rim.
glm::dvec3 partingDirection(const EdgePlane& plane, const Directions& shared, const glm::dvec3& offset,
                            const glm::dvec3& predicted, double slack);

}  // namespace tandem::haptics
