#pragma once

// Splits an affine map into a rigid motion and what is left, so that parts can be rigid (invariant 1 of
// scene.h).

#include <optional>

#include <glm/mat3x3.hpp>
#include <glm/mat4x4.hpp>

#include "assets/base/pose.h"

namespace tandem::assets {

/// map(x) = rigid(residual * x).
struct RigidSplit {
  Pose rigid;
  glm::dmat3 residual{1.0};  // symmetric: scales and shears; negative definite where the map mirrors
};

/// The polar decomposition A = R S of an affine map (Higham 1986, "Computing the polar decomposition"). The
/// residual depends on the scales alone, not on the rotation, so rotated instances of a mesh share it. For a
/// map that mirrors, R keeps det > 0 and S = -(R' A), and the caller flips the winding. Nothing if the map is
/// singular or not finite.
std::optional<RigidSplit> splitRigid(const glm::dmat4& map);

/// The pose as a matrix.
glm::dmat4 toMatrix(const Pose& pose);

}  // namespace tandem::assets
