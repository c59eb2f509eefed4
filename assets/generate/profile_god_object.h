#pragma once

// The exact god object of a polygon, as the reference for a proxy on the extruded polygon. Lengths in m.

#include <cstddef>
#include <vector>

#include <glm/vec2.hpp>

namespace tandem::generate {

/// Whether a point lies in a polygon.
bool insideProfile(const std::vector<glm::dvec2>& profile, const glm::dvec2& p);

/// The outline that the centre of a ball follows round a counter-clockwise polygon: edges moved out by
/// `radius`, arcs round convex corners in pieces of at most `turn` rad, concave corners where the moved edges
/// meet. The ball must fit into every gap, and no edge may be shorter than what its concave ends cut off.
std::vector<glm::dvec2> grownProfile(const std::vector<glm::dvec2>& profile, double radius, double turn);

/// A god object in the plane. It stays outside a simple polygon and descends the distance to its goal along
/// the steepest free direction, until no free direction descends. That is the constraint-based method of
/// Zilles & Salisbury 1995 in the limit of infinitely small steps. A step along a straight piece ends at a
/// corner, at a wall or at its minimum. All three have closed forms, so the result is exact but for the
/// rounding of doubles.
class ProfileGodObject {
 public:
  /// The polygon is counter-clockwise, its inside is solid, and it has at least three corners.
  explicit ProfileGodObject(std::vector<glm::dvec2> profile);

  /// Places the god object in free space.
  void place(const glm::dvec2& position);

  /// Follows the goal; returns the place of rest.
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

}  // namespace tandem::generate
