#pragma once

// What the closed loops of one hand and of two share: a person's hand, the block that is held, measures.

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "tests/support/part_cases.h"
#include "tests/support/part_meshes.h"

namespace tandem::test {

inline constexpr double kPeriod = 1e-3;           // s
inline constexpr double kHandStiffness = 100.0;   // N/m
inline constexpr double kHandRotStiffness = 0.2;  // N·m/rad
inline constexpr double kRounding =
    1e-12;  // J, of work summed over tens of thousands of steps of some 1e-5 J

/// A cube of 60 mm.
inline CasePart block(const glm::dvec3& where) {
  return {"block", meshOf(boxSoup(glm::dvec3(0.06), 3)), {where, {1.0, 0.0, 0.0, 0.0}}};
}

/// The box that a point has been in.
struct Extent {
  glm::dvec3 low{1e300}, high{-1e300};
  void note(const glm::dvec3& x) { low = glm::min(low, x), high = glm::max(high, x); }
  double size() const { return glm::length(high - low); }
};

}  // namespace tandem::test
