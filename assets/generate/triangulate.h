#pragma once

#include <array>
#include <vector>

#include <glm/vec2.hpp>

namespace tandem::generate {

/// Cuts a counter-clockwise polygon with counter-clockwise holes into triangles by clipping ears, the best
/// shaped first. Uses every corner and adds none. Holes must lie inside and must not touch each other.
std::vector<std::array<glm::dvec2, 3>> triangulate(const std::vector<glm::dvec2>& outer,
                                                   std::vector<std::vector<glm::dvec2>> holes);

}  // namespace tandem::generate
