#include "haptics/scene/quadric_normal.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <glm/geometric.hpp>

namespace tandem::haptics {
namespace {

constexpr std::size_t kUnknowns = 8, kLinear = 2;
// Weights against a turn and a curvature that the points do not show, relative to theirs: above the rounding
// of coordinates, far below what they show. Where the two cannot be told apart the first estimate stays.
constexpr double kTurnRidge = 1e-4, kCurvatureRidge = 3e-10;
// Distance of the points from the quadric, relative to their distance from its tangent plane, above which
// they are noise.
constexpr double kOffQuadric = 0.02;
constexpr double kFurthestTurn = 0.8;  // cos of the largest correction

using Row = std::array<double, kUnknowns>;

/// Solves the symmetric positive definite system by Cholesky's decomposition; false where it is singular.
bool solveSymmetric(std::array<Row, kUnknowns>& m, Row& b) {
  for (std::size_t j = 0; j < kUnknowns; ++j) {
    for (std::size_t k = 0; k < j; ++k) m[j][j] -= m[j][k] * m[j][k];
    if (!(m[j][j] > 0.0)) return false;
    m[j][j] = std::sqrt(m[j][j]);
    for (std::size_t i = j + 1; i < kUnknowns; ++i) {
      for (std::size_t k = 0; k < j; ++k) m[i][j] -= m[i][k] * m[j][k];
      m[i][j] /= m[j][j];
    }
  }
  for (std::size_t i = 0; i < kUnknowns; ++i) {
    for (std::size_t k = 0; k < i; ++k) b[i] -= m[i][k] * b[k];
    b[i] /= m[i][i];
  }
  for (std::size_t i = kUnknowns; i-- > 0;) {
    for (std::size_t k = i + 1; k < kUnknowns; ++k) b[i] -= m[k][i] * b[k];
    b[i] /= m[i][i];
  }
  return true;
}

Row rowOf(double x, double y, double z) { return {x, y, x * x, x * y, y * y, x * z, y * z, z * z}; }

/// Coordinates of points about a vertex, in units of their distance from it.
struct LocalFrame {
  glm::dvec3 origin, x, y, z;
  double size = 0.0;

  glm::dvec3 of(const glm::dvec3& p) const {
    const glm::dvec3 r = (p - origin) / size;
    return {glm::dot(r, x), glm::dot(r, y), glm::dot(r, z)};
  }
};

LocalFrame frameAt(const glm::dvec3& vertex, const glm::dvec3& normal, std::span<const glm::dvec3> around) {
  LocalFrame frame{vertex, {}, {}, normal, 0.0};
  for (const glm::dvec3& p : around) frame.size = std::max(frame.size, glm::distance(p, vertex));
  const glm::dvec3 other = std::abs(normal.x) < 0.6 ? glm::dvec3(1.0, 0.0, 0.0) : glm::dvec3(0.0, 1.0, 0.0);
  frame.x = glm::normalize(glm::cross(other, normal));
  frame.y = glm::cross(normal, frame.x);
  return frame;
}

double weightAt(const glm::dvec3& local) { return 1.0 / std::max(glm::dot(local, local), 0.01); }

}  // namespace

QuadricFit fitQuadric(const glm::dvec3& vertex, const glm::dvec3& normal,
                      std::span<const glm::dvec3> around) {
  const QuadricFit none{normal, false};
  if (around.size() < kUnknowns) return none;
  const LocalFrame frame = frameAt(vertex, normal, around);
  if (!(frame.size > 0.0)) return none;
  std::array<Row, kUnknowns> products{};
  Row right{};
  double weights = 0.0;
  for (const glm::dvec3& p : around) {
    const glm::dvec3 q = frame.of(p);
    const double weight = weightAt(q);
    const Row row = rowOf(q.x, q.y, q.z);
    weights += weight;
    for (std::size_t i = 0; i < kUnknowns; ++i) {
      right[i] += weight * row[i] * q.z;
      for (std::size_t j = 0; j <= i; ++j) products[i][j] += weight * row[i] * row[j];
    }
  }
  for (std::size_t i = 0; i < kUnknowns; ++i)
    products[i][i] += (i < kLinear ? kTurnRidge : kCurvatureRidge) * weights;
  if (!solveSymmetric(products, right)) return none;

  double off = 0.0, sag = 0.0;
  for (const glm::dvec3& p : around) {
    const glm::dvec3 q = frame.of(p);
    const Row row = rowOf(q.x, q.y, q.z);
    double model = 0.0;
    for (std::size_t i = 0; i < kUnknowns; ++i) model += right[i] * row[i];
    const double curved = q.z - right[0] * q.x - right[1] * q.y;
    off += weightAt(q) * (q.z - model) * (q.z - model);
    sag += weightAt(q) * curved * curved;
  }
  const glm::dvec3 fitted = glm::normalize(frame.z - right[0] * frame.x - right[1] * frame.y);
  const bool usable = off <= kOffQuadric * kOffQuadric * sag && glm::dot(fitted, normal) > kFurthestTurn;
  return usable ? QuadricFit{fitted, true} : none;
}

}  // namespace tandem::haptics
