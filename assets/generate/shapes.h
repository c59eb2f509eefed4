#pragma once

// A small builder of closed solids: loops in the x-y plane, joined by bands along z and closed by flat caps.
// A solid is built surface by surface, as a machinist would describe it; neighbouring surfaces share loops,
// so that their corners coincide exactly and weld. Everything is in m.

#include <array>
#include <cstdint>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "assets/mesh/mesh_analysis.h"

namespace tandem::generate {

/// A closed polygon, counter-clockwise seen from +z.
using Loop = std::vector<glm::dvec2>;

/// A regular polygon with its corners on the circle.
Loop circle(double radius, int segments, const glm::dvec2& centre = glm::dvec2(0.0));

/// A regular polygon whose sides touch the circle from outside, as a hole needs for a shaft of that radius to
/// fit.
Loop circleAround(double radius, int segments, const glm::dvec2& centre = glm::dvec2(0.0));

/// A regular hexagon by its distance across flats, each side in `perSide` steps.
Loop hexagon(double acrossFlats, int perSide);

/// A rectangle around the origin with rounded corners.
Loop roundedRectangle(const glm::dvec2& size, double cornerRadius, int perCorner);

/// `count` centres evenly on a circle; the first at `firstAngle` rad.
std::vector<glm::dvec2> boltCircle(double radius, int count, double firstAngle = 0.0);

/// A point of a profile to revolve: radius and height.
struct ProfilePoint {
  double radius = 0.0;
  double z = 0.0;
};

enum class Facing { up, down };

/// A surface under construction.
class Solid {
 public:
  /// Sets the material slot of all surfaces added from now on.
  void paint(std::uint16_t slot) { slot_ = slot; }

  /// Joins two loops with equal numbers of corners. Seen in the direction from a to b, the outside of a
  /// counter-clockwise loop is on the right: upwards it is an outer wall, downwards the wall of a hole.
  void band(const Loop& a, double za, const Loop& b, double zb);

  /// Revolves an open profile about the z axis through `centre`, with the sides of band().
  void revolve(const std::vector<ProfilePoint>& profile, int segments,
               const glm::dvec2& centre = glm::dvec2(0.0));

  /// A flat face with holes.
  void cap(const Loop& outer, const std::vector<Loop>& holes, double z, Facing facing);

  /// The triangles, with z turned to glTF's upward y. Each has corners of its own.
  assets::TriangleSoup soup() const;

 private:
  void add(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c);

  std::vector<std::array<glm::dvec3, 3>> triangles_;
  std::vector<std::uint16_t> slots_;
  std::uint16_t slot_ = 0;
};

}  // namespace tandem::generate
