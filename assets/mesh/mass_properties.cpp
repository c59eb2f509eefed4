#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "assets/mesh/mesh_analysis.h"

namespace tandem::assets {
namespace {

// The share of its bounding box that an open mesh fills unless its own faces give more; typical of
// sheet-metal covers and castings with a missing face.
constexpr double kOpenFillShare = 0.25;
// The thickness of a flat mesh as a share of its longest extent, so that it has an inertia about every axis.
constexpr double kThinnest = 0.01;

struct Integrals {
  double volume = 0.0;
  glm::dvec3 first{0.0};   // integral of x
  glm::dmat3 second{0.0};  // integral of x x^T
};

/// The volume integrals of Mirtich, "Fast and accurate computation of polyhedral mass properties", J.
/// Graphics Tools 1(2), 1996, about `origin`. Where Mirtich projects each face onto a plane, this sums the
/// signed tetrahedra between the faces and the origin, whose second moments are exact too: V/20 (sum of a a^T
/// + s s^T), s the sum of corners.
Integrals integrate(const Mesh& mesh, const glm::dvec3& origin) {
  Integrals total;
  for (const auto& t : mesh.triangles) {
    const glm::dvec3 a = mesh.positions[t[0]] - origin;
    const glm::dvec3 b = mesh.positions[t[1]] - origin;
    const glm::dvec3 c = mesh.positions[t[2]] - origin;
    const double volume = glm::dot(a, glm::cross(b, c)) / 6.0;
    const glm::dvec3 sum = a + b + c;
    total.volume += volume;
    total.first += volume / 4.0 * sum;
    total.second += volume / 20.0 *
                    (glm::outerProduct(a, a) + glm::outerProduct(b, b) + glm::outerProduct(c, c) +
                     glm::outerProduct(sum, sum));
  }
  return total;
}

/// Sylvester's criterion: all leading minors are positive by more than rounding.
bool isPositiveDefinite(const glm::dmat3& m) {
  const double scale = (m[0][0] + m[1][1] + m[2][2]) / 3.0;
  const double minor = m[0][0] * m[1][1] - m[0][1] * m[1][0];
  return scale > 0.0 && std::isfinite(scale) && m[0][0] > 1e-12 * scale && minor > 1e-12 * scale * scale &&
         glm::determinant(m) > 1e-12 * scale * scale * scale;
}

/// Whether the faces pass every edge equally often in both directions, as those of a solid do.
bool boundsVolume(const Mesh& mesh) {
  std::vector<std::array<std::uint32_t, 3>> manyFaced;  // low, high, direction
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (int e = 0; e < 3; ++e) {
      if (mesh.edgeFlags[t][e] & kEdgeBoundary) return false;
      const std::uint32_t a = mesh.triangles[t][e], b = mesh.triangles[t][(e + 1) % 3];
      if (mesh.edgeFlags[t][e] & kEdgeNonManifold) {
        manyFaced.push_back({std::min(a, b), std::max(a, b), a < b ? 1u : 0u});
        continue;
      }
      const std::uint32_t other = mesh.neighbours[t][e];
      bool opposite = false;
      for (int k = 0; k < 3; ++k)
        opposite = opposite || (mesh.triangles[other][k] == b && mesh.triangles[other][(k + 1) % 3] == a);
      if (!opposite) return false;
    }
  }
  std::sort(manyFaced.begin(), manyFaced.end());
  for (std::size_t first = 0, last = 0; first < manyFaced.size(); first = last) {
    int balance = 0;
    for (; last < manyFaced.size() && manyFaced[last][0] == manyFaced[first][0] &&
           manyFaced[last][1] == manyFaced[first][1];
         ++last)
      balance += manyFaced[last][2] == 1u ? 1 : -1;
    if (balance != 0) return false;
  }
  return true;
}

/// A uniform box of the mesh's bounds with the mass of `fill` of its volume.
MassProperties boxOfBounds(const Mesh& mesh, double density, double signedVolume) {
  glm::dvec3 size = mesh.bounds.max - mesh.bounds.min;
  const double longest = std::max({size.x, size.y, size.z});
  size = glm::max(size, glm::dvec3(kThinnest * longest));
  const double box = size.x * size.y * size.z;
  MassProperties result;
  // If only a few faces are missing, the others still measure nearly the whole volume.
  result.mass = density * std::clamp(std::abs(signedVolume), kOpenFillShare * box, box);
  result.centreOfMass = 0.5 * (mesh.bounds.min + mesh.bounds.max);
  const glm::dvec3 s = size * size;
  result.inertia[0][0] = result.mass / 12.0 * (s.y + s.z);
  result.inertia[1][1] = result.mass / 12.0 * (s.z + s.x);
  result.inertia[2][2] = result.mass / 12.0 * (s.x + s.y);
  return result;
}

}  // namespace

MassProperties massProperties(const Mesh& mesh, double density) {
  if (mesh.triangles.empty()) return {};
  const glm::dvec3 origin = 0.5 * (mesh.bounds.min + mesh.bounds.max);
  const Integrals integrals = integrate(mesh, origin);
  if (!mesh.closed && !boundsVolume(mesh)) return boxOfBounds(mesh, density, integrals.volume);
  if (!(integrals.volume > 0.0)) return boxOfBounds(mesh, density, 0.0);

  MassProperties result;
  result.mass = density * integrals.volume;
  const glm::dvec3 centre = integrals.first / integrals.volume;
  result.centreOfMass = origin + centre;
  const glm::dmat3 second = density * integrals.second - result.mass * glm::outerProduct(centre, centre);
  result.inertia = glm::dmat3(second[0][0] + second[1][1] + second[2][2]) - second;
  // Overlapping shells with opposite signs can have a volume without a positive inertia.
  return isPositiveDefinite(result.inertia) ? result : boxOfBounds(mesh, density, integrals.volume);
}

}  // namespace tandem::assets
