#include "assets/base/affine.h"

#include <algorithm>
#include <cmath>

#include <glm/gtc/matrix_transform.hpp>
#include <glm/matrix.hpp>

namespace tandem::assets {
namespace {

double largestEntry(const glm::dmat3& m) {
  double largest = 0.0;
  for (int c = 0; c < 3; ++c)
    for (int r = 0; r < 3; ++r) largest = std::max(largest, std::abs(m[c][r]));
  return largest;
}

bool allFinite(const glm::dmat3& m) {
  double sum = 0.0;  // stays finite only if all entries are
  for (int c = 0; c < 3; ++c)
    for (int r = 0; r < 3; ++r) sum += m[c][r] * 0.0;
  return sum == 0.0;
}

/// The orthogonal factor by Newton's iteration, whose quadratic convergence leaves only rounding at the end.
std::optional<glm::dmat3> orthogonalFactor(const glm::dmat3& a) {
  glm::dmat3 x = a;
  for (int i = 0; i < 100; ++i) {
    const double determinant = glm::determinant(x);
    if (!(std::abs(determinant) > 1e-30)) return std::nullopt;
    const glm::dmat3 next = 0.5 * (x + glm::transpose(glm::inverse(x)));
    if (!allFinite(next)) return std::nullopt;
    const double change = largestEntry(next - x);
    x = next;
    if (change < 1e-15 * 8.0) return x;
    if (i > 60 && change < 1e-12) return x;
  }
  return std::nullopt;
}

}  // namespace

std::optional<RigidSplit> splitRigid(const glm::dmat4& map) {
  const glm::dmat3 linear(map);
  const glm::dvec3 translation(map[3]);
  const double size = largestEntry(linear);
  if (!allFinite(linear) || !(size > 1e-150 && size < 1e150)) return std::nullopt;
  if (!(glm::length(translation) < 1e150)) return std::nullopt;
  std::optional<glm::dmat3> rotation = orthogonalFactor(linear / size);
  if (!rotation) return std::nullopt;
  if (glm::determinant(*rotation) < 0.0) *rotation = -*rotation;
  RigidSplit split;
  split.rigid.position = translation;
  split.rigid.orientation = glm::normalize(glm::quat_cast(*rotation));
  // Uses the matrix of the quaternion, so that rigid * residual reproduces the map to the last bits.
  const glm::dmat3 back = glm::transpose(glm::mat3_cast(split.rigid.orientation)) * linear;
  split.residual = 0.5 * (back + glm::transpose(back));
  return split;
}

glm::dmat4 toMatrix(const Pose& pose) {
  glm::dmat4 matrix(glm::mat3_cast(pose.orientation));
  matrix[3] = glm::dvec4(pose.position, 1.0);
  return matrix;
}

}  // namespace tandem::assets
