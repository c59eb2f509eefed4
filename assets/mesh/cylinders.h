#pragma once

// Cylinders in a mesh of triangles: shafts and bores that a CAD program has cut into flat facets.

#include <vector>

#include <glm/vec3.hpp>

#include "assets/scene/scene.h"

namespace tandem::assets {

/// A part of a cylinder, at least half way around, in the mesh's frame.
struct Cylinder {
  glm::dvec3 middle{0.0, 0.0, 0.0};  // m, on the axis, half way along
  glm::dvec3 axis{0.0, 0.0, 1.0};    // unit
  double radius = 0.0;               // m, of the circle on which the facets' edges lie
  double halfLength = 0.0;           // m
  int segments = 0;                  // facets of a whole turn, as wide as those that are there
  bool hollow = false;               // a bore; else a shaft

  /// Distance of a facet's middle from that circle, m.
  double sag() const;
};

/// Edges between flat facets that lie side by side, parallel, and turn by the same angle, at most an eighth
/// of a circle, and whose ends lie on one circle. O(triangles); needs the mesh's neighbours.
std::vector<Cylinder> findCylinders(const Mesh& mesh);

}  // namespace tandem::assets
