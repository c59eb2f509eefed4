#pragma once

// Section planes as the panel and --section set them: on each axis of the world one that cuts away what lies
// beyond a position and one for what lies before it, and planes of any direction. Six planes leave a box.

#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <glm/gtc/quaternion.hpp>

#include "assets/base/result.h"
#include "assets/document/entry.h"

namespace tandem::client {

/// A plane of any direction; what lies in front of it, normal . x > place, is cut away.
struct ObliqueSection {
  glm::dvec3 normal{0.0, 0.0, 1.0};  // unit, world
  double place = 0.0;                // m
};

struct SectionSet {
  std::array<std::optional<double>, 3> beyond;  // m, world: what has a larger coordinate is cut away
  std::array<std::optional<double>, 3> before;  // m, world: what has a smaller one is
  std::vector<ObliqueSection> oblique;

  SectionSet() = default;
  /// These planes, as those of a view; planes without a direction are left out.
  explicit SectionSet(std::span<const document::SectionPlane> planes);

  bool any() const { return count() > 0; }
  std::size_t count() const;
  /// Whether no plane can be added.
  bool full() const { return count() >= document::kMaxSections; }
  std::vector<document::SectionPlane> planes() const;
  /// Moves one of planes() along its normal, m.
  void move(std::size_t index, double by);
  /// Turns one of planes() about a point of it, m, world; a plane square to an axis is not turned.
  void turn(std::size_t index, const glm::dquat& rotation, const glm::dvec3& about);
  /// Adds "x=0.05" (beyond x = 0.05 m) or "-x=0.05" (before it), likewise y and z; or "NX,NY,NZ,M" (beyond
  /// M m from the origin in the direction NX,NY,NZ). The error says what is wrong with the text; nothing has
  /// changed then.
  Status add(const std::string& text);
  Status addAll(const std::vector<std::string>& texts);

 private:
  Status addOblique(const std::string& text);
};

}  // namespace tandem::client
