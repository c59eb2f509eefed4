#include "haptics/scene/field_resolution.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

#include <glm/geometric.hpp>

namespace tandem::haptics {
namespace {

constexpr double kSmoothCosine = 0.94;  // cosine of 20 degrees
constexpr double kLeftOut = 0.05;       // share of the surface: fillets and the like

struct Face {
  glm::dvec3 normal{0.0, 0.0, 0.0};  // unit
  double area = 0.0;                 // m^2
};

std::vector<Face> facesOf(const assets::Mesh& mesh) {
  std::vector<Face> faces;
  faces.reserve(mesh.triangles.size());
  for (const auto& c : mesh.triangles) {
    const glm::dvec3 area =
        glm::cross(mesh.positions[c[1]] - mesh.positions[c[0]], mesh.positions[c[2]] - mesh.positions[c[0]]);
    const double length = glm::length(area);
    faces.push_back(length > 0.0 ? Face{area / length, 0.5 * length} : Face{});
  }
  return faces;
}

/// Largest curvature over a triangle's smooth edges, 1/m.
double curvatureAt(const assets::Mesh& mesh, const std::vector<Face>& faces, std::size_t t) {
  double steepest = 0.0;
  for (std::size_t e = 0; e < 3; ++e) {
    const std::uint32_t other = mesh.neighbours[t][e];
    if (other == assets::kNone) continue;
    const double cosine = glm::dot(faces[t].normal, faces[other].normal);
    if (cosine < kSmoothCosine) continue;
    const auto& corners = mesh.triangles[t];
    const double length = glm::distance(mesh.positions[corners[e]], mesh.positions[corners[(e + 1) % 3]]);
    const double turn = glm::length(glm::cross(faces[t].normal, faces[other].normal));
    // Distance between the centres of the two faces; both are halves of a strip along the edge.
    const double width = (faces[t].area + faces[other].area) / length;
    if (width > 0.0) steepest = std::max(steepest, turn / width);
  }
  return steepest;
}

}  // namespace

double cellForCurves(const assets::Mesh& mesh, double tolerance) {
  const std::vector<Face> faces = facesOf(mesh);
  std::vector<std::pair<double, double>> curved;  // curvature and area
  double whole = 0.0;
  for (std::size_t t = 0; t < faces.size() && t < mesh.neighbours.size(); ++t) {
    whole += faces[t].area;
    if (faces[t].area > 0.0) curved.emplace_back(curvatureAt(mesh, faces, t), faces[t].area);
  }
  std::sort(curved.begin(), curved.end(), [](const auto& l, const auto& r) { return l.first > r.first; });
  double left = kLeftOut * whole;
  for (const auto& [curvature, area] : curved) {
    left -= area;
    if (left > 0.0) continue;
    const double radius = std::sqrt(4.0 * tolerance / std::max(curvature, 1e-300));
    return 2.0 / std::numbers::sqrt3 * radius;
  }
  return std::numeric_limits<double>::infinity();
}

}  // namespace tandem::haptics
