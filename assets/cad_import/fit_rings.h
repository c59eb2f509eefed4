#pragma once

// Angles at which round surfaces are cut into facets, chosen so that a shaft and the bore in which it stands
// have their edges side by side. Two polygons about one axis and in phase do not cross; out of phase the
// shaft's corners stand in the bore's facets by their sag, although the surfaces only touch.

#include <cstdint>
#include <vector>

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>

namespace tandem::cad_import {

/// A cylinder of a body, in the body's frame, mm.
struct Ring {
  std::uint32_t body = 0;
  glm::dvec3 origin{0.0};          // on the axis
  glm::dvec3 axis{0.0, 0.0, 1.0};  // unit
  glm::dvec3 zero{1.0, 0.0, 0.0};  // unit, across the axis: angle 0; angles grow right-handed about the axis
  double radius = 1.0;
  double from = 0.0, to = 0.0;  // along the axis
  bool hollow = false;
  std::vector<double> corners;  // rad; where vertices of the body stand, which the ring must have
  double step = 0.2;            // rad between neighbours, at most
};

/// A body at a place of the assembly.
struct Placement {
  std::uint32_t body = 0;
  glm::dmat4 worldFromBody{1.0};  // rigid, mm
};

struct RingAngles {
  std::vector<std::vector<double>> angles;  // one list a ring: rad, ascending, in [0, 2 pi)
  std::size_t fits = 0;                     // pairs of a shaft and a bore that are cut alike
  std::size_t unlike = 0;                   // pairs of which no angles suit all places of both
};

/// The angles of each ring. A fit is a shaft and a bore that overlap along one axis and whose radii differ by
/// less than facets deviate from the circle.
RingAngles chooseAngles(const std::vector<Ring>& rings, const std::vector<Placement>& placements);

}  // namespace tandem::cad_import
