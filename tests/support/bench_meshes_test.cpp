#include <gtest/gtest.h>

#include <cmath>

#include <glm/geometric.hpp>

#include "tests/support/bench_meshes.h"

namespace tandem::tests {
namespace {

double area(const std::vector<glm::dvec2>& polygon) {
  double twice = 0.0;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const glm::dvec2 &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    twice += a.x * b.y - a.y * b.x;
  }
  return 0.5 * twice;
}

TEST(BenchMeshes, EveryTessellationOfTheGearIsTheExtrudedProfile) {
  const double expected = area(gearProfile()) * kGearHeight;
  EXPECT_GT(expected, 0.0);
  for (const int triangles : {1, 5'000, 60'000}) {
    const assets::Mesh mesh = gearMesh(triangles);
    EXPECT_GE(mesh.triangles.size(), static_cast<std::size_t>(triangles));
    EXPECT_TRUE(mesh.closed) << triangles;
    EXPECT_EQ(mesh.shellCount, 1u);
    EXPECT_NEAR(mesh.volume, expected, 1e-12 * expected);
  }
}

TEST(BenchMeshes, GearTrianglesFaceOutwardsBeforeTheAnalysisCouldTurnThem) {
  const assets::Mesh mesh = gearMesh(5'000, Topology::never);
  double volume = 0.0;
  for (const auto& [a, b, c] : mesh.triangles) {
    volume += glm::dot(mesh.positions[a], glm::cross(mesh.positions[b], mesh.positions[c])) / 6.0;
    EXPECT_GT(
        glm::length(glm::cross(mesh.positions[b] - mesh.positions[a], mesh.positions[c] - mesh.positions[a])),
        0.0);
  }
  EXPECT_NEAR(volume, area(gearProfile()) * kGearHeight, 1e-12 * volume);
}

TEST(BenchMeshes, SphereIsClosedAndOfNearlyEqualTriangles) {
  const assets::Mesh mesh = sphereMesh(0.01, 20'000);
  EXPECT_EQ(mesh.triangles.size(), 20'000u);
  EXPECT_TRUE(mesh.closed);
  EXPECT_GT(mesh.volume, 0.999 * 4.0 / 3.0 * 3.14159265 * 1e-6);
  double shortest = 1e300, longest = 0.0;
  for (const auto& t : mesh.triangles) {
    for (int e = 0; e < 3; ++e) {
      const double length = glm::length(mesh.positions[t[e]] - mesh.positions[t[(e + 1) % 3]]);
      shortest = std::min(shortest, length);
      longest = std::max(longest, length);
    }
  }
  EXPECT_LT(longest / shortest, 2.0);
}

TEST(BenchMeshes, ScenesHaveTheirParts) {
  EXPECT_EQ(plateGrid(100, 0.002, 0.001).parts.size(), 10'000u);
  const assets::Scene scene = smallParts(1000);
  EXPECT_EQ(scene.parts.size(), 1000u);
  EXPECT_TRUE(scene.parts[999].movable);
  EXPECT_GE(scene.meshes[0].triangles.size(), 200u);
}

}  // namespace
}  // namespace tandem::tests
