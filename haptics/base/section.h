#pragma once

// Sections: planes that cut the scene open. What lies in front of one of them is not there for a hand.

#include <cstddef>

#include <glm/vec3.hpp>

#include "haptics/base/fixed_vector.h"

namespace tandem::haptics {

inline constexpr std::size_t kMaxSections = 8;

/// A plane; what lies in front of it, normal . x > offset, is cut away. What several planes leave is convex.
struct Section {
  glm::dvec3 normal{0.0, 0.0, 0.0};  // unit
  double offset = 0.0;               // m

  bool operator==(const Section&) const = default;
};

using Sections = FixedVector<Section, kMaxSections>;

}  // namespace tandem::haptics
