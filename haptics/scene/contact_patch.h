#pragma once

// The piece of a round surface that one sample stands for: where on it something is touched first.
//
//   cap       of a sphere: `centre` and `radius`, within `angle` of the direction `out`
//   side      of a cone or cylinder: spheres whose centres lie on `centre + t axis`, |t| <= along, with radii
//             `radius + t grow`, touch it from inside; `out` across the axis, within `angle` of it
//   rim       a circle about `axis`, which is the normal of the face that it bounds; `grow` as above, along that axis.
//             What lies on that face may hide it: the normal of what is seen in its place has `cap` across the axis
//   straight  a piece of a straight edge: `centre + t axis`, |t| <= along
//
// Of the points of a patch that are equally deep to within the `slack` that a caller allows the one nearest to the
// sample is taken: what lies flat on something does not rock from one end of its samples to the other.

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
  double grow = 0.0;                 // m a m along the axis
  double along = 0.0;                // m
  double angle = 0.0;                // rad
  double cap = 0.0;                  // of a unit vector

  /// Where its sample lies, and which way the surface looks there (of a rim, across the axis).
  glm::dvec3 sample() const { return pointAt({out, 0.0}); }
  /// How far any of its points is from the sample, at most, m.
  double reach() const;

  /// One of its points: `out` across the axis (of a cap, the normal), t along it.
  struct Place {
    glm::dvec3 out{0.0, 0.0, 0.0};
    double t = 0.0;  // m
  };
  glm::dvec3 pointAt(const Place& place) const;
  /// The surface's normals there: two at a rim.
  int normalsAt(const Place& place, std::array<glm::dvec3, 2>& normals) const;

  /// The place that lies lowest along the unit vector `up`, to within `slack` m.
  Place lowest(const glm::dvec3& up, double slack) const;
  /// The place nearest to a point, of what lies on the axis nearest to that.
  Place nearestTo(const glm::dvec3& p) const;
  /// Towards `wanted` across the axis, as far as the patch goes; `slack` m as for lowest().
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
