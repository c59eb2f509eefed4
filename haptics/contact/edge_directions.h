#pragma once

// In which directions an edge of one body and a corner or edge of another can hold each other apart: across the edge,
// within its own normals, and opposite to a normal of the other.

#include <span>

#include <glm/vec3.hpp>

#include "haptics/geometry/mesh_edges.h"

namespace tandem::haptics {

/// Directions across an edge as angles from its first normal towards the second; rad.
class EdgePlane {
 public:
  explicit EdgePlane(const MeshEdge& edge);
  /// Unrolled to within half a turn of the middle of the edge's own directions.
  double angle(const glm::dvec3& v) const;
  /// Of the part of v that lies across the edge.
  double length(const glm::dvec3& v) const;
  glm::dvec3 direction(double angle) const;
  /// Of the second normal.
  double end() const { return end_; }
  /// Unit, along the edge.
  const glm::dvec3& along() const { return along_; }

 private:
  glm::dvec3 along_, first_, second_;
  double end_;
};

/// Those from `low` to `high`, in rad; none where high < low.
struct Directions {
  double low = 0.0, high = -1.0;
  bool none() const { return high < low; }
};

/// The directions of the edge that are opposite to a normal of the other body there: the section of the cone that its
/// `normals` (unit) span with the plane across the edge.
Directions commonDirections(const EdgePlane& plane, std::span<const glm::dvec3> normals);

/// Those that are nearly so: the shadow of the cone on that plane, or the end of the edge's own that is nearest to it.
Directions nearestDirections(const EdgePlane& plane, std::span<const glm::dvec3> normals);

/// The one of `shared` in which the predicted offset from the edge is longest, with the present one not below -slack m
/// where that can be: a corner that lies a hair over the rim must move by that hair, not climb around it.
glm::dvec3 partingDirection(const EdgePlane& plane, const Directions& shared, const glm::dvec3& offset,
                            const glm::dvec3& predicted, double slack);

}  // namespace tandem::haptics
