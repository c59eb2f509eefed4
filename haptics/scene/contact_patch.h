#pragma once

// Contact patch: the piece of a round surface that one sample represents, and the place on it that touches
// first.
//
//   cap       of a sphere: `centre` and `radius`, within `angle` of the direction `out`
//   side      of a cone or cylinder: spheres whose centres lie on `centre + t axis`, |t| <= along, with radii
//             `radius + t grow`, touch it from inside; `out` across the axis, within `angle` of it
//   rim       a circle about `axis`, the normal of the face that it bounds; `grow` as above, along that axis.
//             A shape that lies on the face may cover it; the visible normal then has `cap` across the axis
//   straight  a piece of a straight edge: `centre + t axis`, |t| <= along
//
// Among the points of a patch that are equally deep to within the `slack` that a caller allows, the one
// nearest to the sample is chosen, so that a part that lies flat does not rock between the ends of its
// patches.

#include <array>
#include <cmath>
#include <cstdint>

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include "assets/base/pose.h"

namespace tandem::haptics {

struct ContactPatch {
  enum class Kind : std::uint8_t { cap, side, rim, straight };
  Kind kind = Kind::cap;
  glm::dvec3 centre{0.0, 0.0, 0.0};  // m
  glm::dvec3 axis{0.0, 1.0, 0.0};    // unit
  glm::dvec3 out{1.0, 0.0, 0.0};     // unit
  double radius = 0.0;               // m
  double grow = 0.0;                 // m per m along the axis
  double along = 0.0;                // m
  double angle = 0.0;                // rad
  double cap = 0.0;                  // of a unit vector

  /// The sample, and the direction of the surface there (of a rim, across the axis).
  glm::dvec3 sample() const { return pointAt({out, 0.0}); }
  /// Upper bound of the distance of its points from the sample, m.
  double reach() const;

  /// One of its points: `out` across the axis (of a cap, the normal), t along the axis.
  struct Place {
    glm::dvec3 out{0.0, 0.0, 0.0};
    double t = 0.0;  // m
  };
  glm::dvec3 pointAt(const Place& place) const;
  /// The surface normals at a point: two at a rim.
  int normalsAt(const Place& place, std::array<glm::dvec3, 2>& normals) const;

  /// The lowest point along the unit vector `up`, to within `slack` m.
  Place lowest(const glm::dvec3& up, double slack) const;
  /// The point nearest to p; of the points on the axis, the one nearest to p comes first.
  Place nearestTo(const glm::dvec3& p) const;
  /// The direction across the axis nearest to `wanted` within the patch; `slack` (m) as for lowest().
  glm::dvec3 turned(const glm::dvec3& wanted, double slack) const;

  ContactPatch moved(const Pose& pose) const {
    ContactPatch m = *this;
    m.centre = transformPoint(pose, centre);
    m.axis = pose.orientation * axis;
    m.out = pose.orientation * out;
    return m;
  }
};

}  // namespace tandem::haptics
