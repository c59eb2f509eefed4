#pragma once

// Inside or outside of a mesh, asked of every triangle and of nothing that is under test.

#include <cmath>

#include <glm/geometric.hpp>

#include "assets/scene/scene.h"
#include "tests/support/shapes.h"

namespace tandem::test {

/// Winding number of a mesh around p: the sum of the solid angles of all triangles (van Oosterom & Strackee
/// 1983, "The solid angle of a plane triangle") over 4 pi. Inside a closed mesh oriented outwards it is 1.
inline double windingNumber(const assets::Mesh& mesh, const glm::dvec3& p) {
  double sum = 0.0;
  for (const auto& t : mesh.triangles) {
    const glm::dvec3 a = mesh.positions[t[0]] - p, b = mesh.positions[t[1]] - p, c = mesh.positions[t[2]] - p;
    const double la = glm::length(a), lb = glm::length(b), lc = glm::length(c);
    sum += std::atan2(glm::dot(a, glm::cross(b, c)),
                      la * lb * lc + glm::dot(a, b) * lc + glm::dot(b, c) * la + glm::dot(c, a) * lb);
  }
  return sum / (2.0 * kPi);
}

}  // namespace tandem::test
