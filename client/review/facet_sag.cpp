#include "client/review/facet_sag.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "assets/base/assert.h"

namespace tandem::client {
namespace {

/// Normal of a triangle, as long as twice its area, m^2.
glm::dvec3 doubleArea(const assets::Mesh& mesh, std::uint32_t triangle) {
  const auto& c = mesh.triangles[triangle];
  return glm::cross(mesh.positions[c[1]] - mesh.positions[c[0]], mesh.positions[c[2]] - mesh.positions[c[0]]);
}

}  // namespace

double facetSag(const assets::Mesh& mesh, std::uint32_t triangle) {
  ASSERT(triangle < mesh.triangles.size());
  if (triangle >= mesh.neighbours.size() || triangle >= mesh.edgeFlags.size()) return 0.0;
  const auto& corners = mesh.triangles[triangle];
  const glm::dvec3 normal = doubleArea(mesh, triangle);
  const double area = glm::length(normal);
  double sag = 0.0;
  for (std::size_t e = 0; e < 3; ++e) {
    const std::uint32_t neighbour = mesh.neighbours[triangle][e];
    if (neighbour == assets::kNone || (mesh.edgeFlags[triangle][e] & assets::kEdgeSharp) != 0) continue;
    const glm::dvec3 other = doubleArea(mesh, neighbour);
    const double edge = glm::length(mesh.positions[corners[(e + 1) % 3]] - mesh.positions[corners[e]]);
    if (!(area > 0.0) || !(glm::length(other) > 0.0) || !(edge > 0.0)) continue;
    const double turn = std::atan2(glm::length(glm::cross(normal, other)), glm::dot(normal, other));
    // A flat face beside the narrow facets of a fillet is no chord of the fillet, so the narrower of both
    // counts.
    const double chord = std::min(area, glm::length(other)) / edge;
    sag = std::max(sag, 0.5 * chord * std::tan(0.25 * turn));
  }
  return sag;
}

double facetSag(const assets::Mesh& mesh) {
  double sag = 0.0;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
    sag = std::max(sag, facetSag(mesh, static_cast<std::uint32_t>(i)));
  return sag;
}

}  // namespace tandem::client
