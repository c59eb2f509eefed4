#include "assets/scene/smooth_normals.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

namespace tandem::assets {
namespace {

constexpr double kAgree = 1e-3, kAgreeShare = 0.1, kAgreeMost = 0.02;
constexpr double kFurthest = 0.766;  // cos of 40 degrees between a normal and its facet
constexpr double kLeastTurn = 1e-4;  // rad, above the angles that rounding to floats gives a plane
constexpr double kFlat = 1e-6;       // 1 - cos of a normal that is its facet's

glm::dvec3 facetOf(const Mesh& mesh, std::size_t t) {
  const auto& c = mesh.triangles[t];
  const glm::dvec3 n =
      glm::cross(mesh.positions[c[1]] - mesh.positions[c[0]], mesh.positions[c[2]] - mesh.positions[c[0]]);
  const double length = glm::length(n);
  return length > 0.0 ? n / length : glm::dvec3(0.0, 0.0, 1.0);
}

void settle(const glm::dvec3& facet, std::array<glm::vec3, 3>& normals) {
  // A file may wind its triangles against its normals, and the mesh may have been turned.
  int against = 0;
  for (const glm::vec3& n : normals) against += glm::dot(glm::dvec3(n), facet) < 0.0 ? 1 : 0;
  for (glm::vec3& n : normals) {
    const glm::dvec3 own = (against == 3 ? -1.0 : 1.0) * glm::dvec3(n);
    const double length = glm::length(own);
    const bool usable = std::isfinite(length) && glm::dot(own, facet) > kFurthest * length;
    n = glm::vec3(usable ? own / length : facet);
  }
}

/// Whether edge e of triangle t turns although the normals agree at one of its ends.
bool isRounded(const Mesh& mesh, std::size_t t, std::size_t e) {
  const std::uint32_t n = mesh.neighbours[t][e];
  if (n == kNone || n < t) return false;
  const glm::dvec3 own = facetOf(mesh, t), other = facetOf(mesh, n);
  if (!(glm::distance(own, other) > kLeastTurn)) return false;
  for (const std::size_t c : {e, (e + 1) % 3})
    for (std::size_t o = 0; o < 3; ++o)
      if (mesh.triangles[n][o] == mesh.triangles[t][c]) {
        const double apart =
            glm::distance(glm::dvec3(mesh.triangleNormal[t][c]), glm::dvec3(mesh.triangleNormal[n][o]));
        if (apart < kAgreeShare * glm::distance(own, other)) return true;
      }
  return false;
}

}  // namespace

bool agreeAcross(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& facetA,
                 const glm::dvec3& facetB) {
  const double turn = glm::distance(facetA, facetB);
  return glm::distance(a, b) <= std::max(kAgree, std::min(kAgreeShare * turn, kAgreeMost));
}

void settleNormals(Mesh& mesh) {
  if (mesh.triangleNormal.empty()) return;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) settle(facetOf(mesh, t), mesh.triangleNormal[t]);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (std::size_t e = 0; e < 3; ++e)
      if (isRounded(mesh, t, e)) return;
  mesh.triangleNormal = {};
}

std::uint64_t smoothTriangles(const Mesh& mesh, std::uint16_t material) {
  std::uint64_t count = 0;
  for (std::size_t t = 0; t < mesh.triangleNormal.size(); ++t) {
    if (mesh.triangleMaterial[t] != material) continue;
    const glm::dvec3 facet = facetOf(mesh, t);
    const auto& normals = mesh.triangleNormal[t];
    count += std::any_of(normals.begin(), normals.end(),
                         [&](const glm::vec3& n) { return glm::dot(glm::dvec3(n), facet) < 1.0 - kFlat; })
                 ? 1
                 : 0;
  }
  return count;
}

void dropNormals(Scene& scene) {
  for (Mesh& mesh : scene.meshes) mesh.triangleNormal = {};
}

}  // namespace tandem::assets
