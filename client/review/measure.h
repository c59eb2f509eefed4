#pragma once

// Measures places on the surfaces of parts: edges, cylinders, angles and distances, as a reviewer asks for
// them. Exact on the triangles that contact uses, to rounding in double.
//
// 1. A cylinder is one that assets/mesh finds in CAD facets, of at least ten segments a turn, or an implicit
//    shape. Its diameter is that of the circle on which the facets' corners lie; a bore whose facets touch
//    the circle with their middles is wider by its sag, unless loading has given it room (equal_fits.h).
// 2. Safe in every thread: the geometry is only read. Allocates.

#include <optional>
#include <span>

#include <glm/vec3.hpp>

#include "assets/base/ids.h"
#include "assets/base/pose.h"
#include "assets/mesh/cylinders.h"
#include "haptics/scene/contact_scene.h"

namespace tandem::client {

/// A run of edges that goes on without a corner: where exactly two edges meet and turn by at most 45 degrees.
struct MeasuredEdge {
  glm::dvec3 start{0.0, 0.0, 0.0}, end{0.0, 0.0, 0.0};  // m, world; the same point if it is closed
  double length = 0.0;                                  // m, the sum of its segments
  int segments = 0;
};

/// A place on the surface of a part, world frame.
struct MeasuredPlace {
  PartId part = kNoPart;
  glm::dvec3 point{0.0, 0.0, 0.0};           // m
  glm::dvec3 normal{0.0, 0.0, 0.0};          // unit, of the triangle, outwards
  std::optional<MeasuredEdge> edge;          // the nearest of the part; none: it has no edges
  std::optional<assets::Cylinder> cylinder;  // whose side the place is on
};

/// What two places say about each other.
struct MeasuredPair {
  double distance = 0.0;         // m, from point to point
  double angle = 0.0;            // rad, 0 to pi/2: of two faces, of two axes, or of a face and an axis
  std::optional<double> across;  // m, between parallel faces, parallel axes, or an axis and a face along it
};

/// The place nearest to a point (m, world) on any part, with the parts at these poses (one a part; empty: the
/// file's). Nothing if no part has geometry.
std::optional<MeasuredPlace> measurePlace(const haptics::ContactScene& contact, const glm::dvec3& point,
                                          std::span<const Pose> worldFromPart = {});

/// The place of one part nearest to a point, both in the part's frame. Nothing if the part has no geometry.
std::optional<MeasuredPlace> measurePlaceOn(const haptics::ContactScene& contact, PartId part,
                                            const glm::dvec3& point);
/// The place, its edge and its cylinder carried from the part's frame into the world by the part's pose.
MeasuredPlace moved(MeasuredPlace place, const Pose& pose);

MeasuredPair measurePair(const MeasuredPlace& a, const MeasuredPlace& b);

}  // namespace tandem::client
