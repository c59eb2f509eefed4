#pragma once

// Where an ideal god object would be, in closed form or by exact descent: what every measured force is
// compared with. Lengths in m, part frame.

#include <cstddef>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

namespace tandem::client::report {

/// The nearest allowed place of a ball's centre to `goal` outside a sphere around the origin; `radius` is
/// that of the sphere plus that of the ball. Undefined at the very centre: then +z.
glm::dvec3 outsideSphere(const glm::dvec3& goal, double radius);

/// The nearest point to `goal` with z >= height.
glm::dvec3 abovePlane(const glm::dvec3& goal, double height);

/// The nearest point to `goal` between the walls of a groove along y with its apex at the origin, each wall
/// at `halfAngle` rad from +z: |x| cos(halfAngle) <= z sin(halfAngle).
glm::dvec3 insideGroove(const glm::dvec3& goal, double halfAngle);

/// A god object in the plane: it stays outside a simple polygon and goes down the distance to its goal, along
/// the steepest way that the polygon leaves open, to the first place where no way leads down. That is the
/// constraint-based method of Zilles & Salisbury 1995 in the limit of infinitely small steps. A step along a
/// straight piece ends at a corner, at a wall or at its minimum, all three found in closed form: the answer
/// is exact but for the rounding of doubles.
class ProfileGodObject {
 public:
  /// The polygon is counter-clockwise with its solid inside; it must have three corners or more.
  explicit ProfileGodObject(std::vector<glm::dvec2> profile);

  /// Puts the god object somewhere in free space.
  void place(const glm::dvec2& position);

  /// Follows the goal; returns where it comes to rest.
  glm::dvec2 follow(const glm::dvec2& goal);

 private:
  enum class Where { free, edge, corner };

  glm::dvec2 corner(std::size_t i) const { return profile_[i % profile_.size()]; }
  glm::dvec2 along(std::size_t edge) const { return corner(edge + 1) - corner(edge); }
  glm::dvec2 outward(std::size_t edge) const;

  bool stepFree(const glm::dvec2& goal);
  bool stepEdge(const glm::dvec2& goal);
  bool stepCorner(const glm::dvec2& goal);

  std::vector<glm::dvec2> profile_;
  glm::dvec2 position_{0.0, 0.0};
  Where where_ = Where::free;
  std::size_t index_ = 0;                            // of the edge or the corner it rests on
  std::size_t leftA_ = kNothing, leftB_ = kNothing;  // edges that a free step starts from
  static constexpr std::size_t kNothing = static_cast<std::size_t>(-1);
};

}  // namespace tandem::client::report
