#pragma once

// The normal of a surface at a vertex from the vertices around it.

#include <span>

#include <glm/vec3.hpp>

namespace tandem::haptics {

struct QuadricFit {
  glm::dvec3 normal{0.0, 0.0, 0.0};  // unit
  bool fits = false;                 // the points lie on a quadric
};

/// The quadric through `vertex` that fits `around` best, and its normal there; `normal` is a first estimate,
/// which is returned where the points do not lie on a quadric. With z the height along that estimate, the
/// fit is linear:
///     z = a x + b y + A x^2 + B x y + C y^2 + D x z + E y z + F z^2
/// in the least squares by the inverse squared distance. It holds for every point of a sphere, a cylinder, a
/// cone, and any other quadric whose tangent plane at the vertex is not along z.
QuadricFit fitQuadric(const glm::dvec3& vertex, const glm::dvec3& normal, std::span<const glm::dvec3> around);

}  // namespace tandem::haptics
