#pragma once

// Cones and cylinders cut into irregular triangles, with what is exactly known of them.

#include <cmath>
#include <random>
#include <vector>

#include <glm/geometric.hpp>

#include "assets/mesh/mesh_analysis.h"
#include "tests/support/shapes.h"

namespace tandem::test {

/// A cone about +z, from z = 0 to its height; a cylinder where both radii are equal.
struct RuledShape {
  double radius = 0.03, topRadius = 0.015, height = 0.06;  // m

  glm::dvec3 at(double angle, double share) const {
    const double r = radius + (topRadius - radius) * share;
    return {r * std::cos(angle), r * std::sin(angle), height * share};
  }
  glm::dvec3 normal(double angle) const {
    const double slope = (radius - topRadius) / height;
    return glm::normalize(glm::dvec3(std::cos(angle), std::sin(angle), slope));
  }
};

/// The shape with both caps, in rows of `around` vertices. They are off by up to `jitter` of a step each way;
/// quads are cut along the convex diagonal. A top radius of 0 makes a fan about the tip. `normals`: with the
/// exact ones, and the caps' own.
inline assets::Mesh ruledMesh(const RuledShape& shape, int around, int rows, double jitter, unsigned seed,
                              bool normals) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> off(-jitter, jitter);
  assets::TriangleSoup soup;
  std::vector<glm::vec3> exact;  // of each vertex
  const auto add = [&](const glm::dvec3& p, const glm::dvec3& n) {
    soup.positions.push_back(glm::dvec3(glm::vec3(p)));
    exact.push_back(glm::vec3(n));
    return static_cast<std::uint32_t>(soup.positions.size() - 1);
  };
  const bool tip = shape.topRadius == 0.0;
  const int last = tip ? rows - 1 : rows;
  std::vector<std::uint32_t> grid;
  for (int j = 0; j <= last; ++j)
    for (int i = 0; i < around; ++i) {
      const double share = (j + (j > 0 && j < last ? off(random) : 0.0)) / rows;
      const double angle = 2.0 * kPi * (i + off(random)) / around;
      grid.push_back(add(shape.at(angle, share), shape.normal(angle)));
    }
  const auto at = [&](int i, int j) { return grid[static_cast<std::size_t>(j * around + i % around)]; };
  const auto triangle = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c, const glm::vec3& cap = {}) {
    soup.triangles.push_back({a, b, c});
    soup.triangleMaterial.push_back(0);
    if (!normals) return;
    if (cap != glm::vec3(0.0f))
      soup.triangleNormal.push_back({cap, cap, cap});
    else
      soup.triangleNormal.push_back({exact[a], exact[b], exact[c]});
  };
  for (int j = 0; j < last; ++j)
    for (int i = 0; i < around; ++i) {
      const std::uint32_t a = at(i, j), b = at(i + 1, j), c = at(i + 1, j + 1), d = at(i, j + 1);
      const auto& p = soup.positions;
      const bool along = glm::dot(glm::cross(p[b] - p[a], p[c] - p[a]), p[d] - p[a]) < 0.0;
      triangle(a, b, along ? c : d);
      triangle(along ? a : b, c, d);
    }
  const std::uint32_t top = add({0.0, 0.0, shape.height}, {0.0, 0.0, 1.0});
  const std::uint32_t bottom = add({0.0, 0.0, 0.0}, {0.0, 0.0, -1.0});
  for (int i = 0; i < around; ++i) {
    triangle(at(i + 1, 0), at(i, 0), bottom, {0.0f, 0.0f, -1.0f});
    triangle(at(i, last), at(i + 1, last), top, tip ? glm::vec3(0.0f) : glm::vec3(0.0f, 0.0f, 1.0f));
  }
  return assets::analyseMesh(std::move(soup), 0.5).mesh;
}

}  // namespace tandem::test
