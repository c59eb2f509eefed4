#include "client/levels/facing.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <utility>

#include "assets/generate/large_assembly.h"
#include "tests/support/shapes.h"

namespace tandem::client {
namespace {

bool outward(const assets::Mesh& mesh) { return facesOutward(mesh, makeRenderMesh(mesh)); }

void turnAround(assets::Mesh& mesh, std::size_t from = 0) {
  for (std::size_t t = from; t < mesh.triangles.size(); ++t) {
    std::swap(mesh.triangles[t][1], mesh.triangles[t][2]);
    std::swap(mesh.neighbours[t][0], mesh.neighbours[t][2]);
    std::swap(mesh.edgeFlags[t][0], mesh.edgeFlags[t][2]);
  }
}

/// Both in one mesh, the second one moved.
assets::Mesh together(assets::Mesh a, const assets::Mesh& b, const glm::dvec3& by) {
  const auto first = static_cast<std::uint32_t>(a.positions.size());
  for (const glm::dvec3& p : b.positions) {
    a.positions.push_back(p + by);
    a.bounds.include(p + by);
  }
  const auto firstTriangle = static_cast<std::uint32_t>(a.triangles.size());
  for (std::size_t t = 0; t < b.triangles.size(); ++t) {
    const auto& [i, j, k] = b.triangles[t];
    a.triangles.push_back({i + first, j + first, k + first});
    const auto& [u, v, w] = b.neighbours[t];
    a.neighbours.push_back({u + firstTriangle, v + firstTriangle, w + firstTriangle});
    a.edgeFlags.push_back(b.edgeFlags[t]);
    a.triangleMaterial.push_back(b.triangleMaterial[t]);
  }
  return a;
}

/// A bar along z whose cross-section is a figure of eight, one half of it much the smaller: a closed surface
/// of positive volume whose small half is inside out.
assets::Mesh figureOfEight() {
  const glm::dvec2 outline[] = {{-0.4, -0.1}, {0.1, 0.025}, {0.1, -0.025}, {-0.4, 0.1}};
  test::ShapeBuilder b;
  for (const double z : {-0.1, 0.1})
    for (const glm::dvec2& p : outline) b.vertex(p.x, p.y, z);
  for (std::uint32_t i = 0; i < 4; ++i) b.quad(i, (i + 1) % 4, 4 + (i + 1) % 4, 4 + i);
  b.quad(4, 5, 6, 7);
  b.quad(3, 2, 1, 0);
  return b.mesh();
}

TEST(Facing, SolidsFaceOutward) {
  EXPECT_TRUE(outward(test::boxMesh({0.3, 0.1, 0.2})));
  EXPECT_TRUE(outward(test::sphereMesh(0.1, 20)));
  const assets::Scene scene = generate::largeAssembly(4, 9000);
  for (const assets::Mesh& mesh : scene.meshes) EXPECT_TRUE(outward(mesh));
}

TEST(Facing, SolidsThatOverlapAndHollowOnesFaceOutward) {
  const assets::Mesh ball = test::sphereMesh(0.1, 20);
  EXPECT_TRUE(outward(together(ball, ball, {0.03, 0.02, 0.01})));
  assets::Mesh hollow = together(ball, test::sphereMesh(0.05, 20), {});
  const std::size_t outside = ball.triangles.size();
  turnAround(hollow, outside);
  EXPECT_TRUE(outward(hollow));
}

TEST(Facing, WhatIsInsideOutDoesNot) {
  assets::Mesh ball = test::sphereMesh(0.1, 20);
  const assets::Mesh whole = ball;
  turnAround(ball);
  EXPECT_FALSE(outward(ball));
  assets::Mesh small = test::sphereMesh(0.002, 8);
  EXPECT_TRUE(outward(together(whole, small, {0.15, 0.0, 0.0})));
  turnAround(small);
  EXPECT_FALSE(outward(together(whole, small, {0.15, 0.0, 0.0}))) << "a hundredth of the mesh across";
}

TEST(Facing, AFigureOfEightDoesNotAlthoughItsVolumeIsPositive) {
  assets::Mesh mesh = figureOfEight();
  ASSERT_TRUE(mesh.closed);
  ASSERT_GT(mesh.volume, 0.0);
  EXPECT_FALSE(outward(mesh));
}

TEST(Facing, AnOpenMeshDoesNot) { EXPECT_FALSE(outward(test::sheetMesh(0.1, 4))); }

}  // namespace
}  // namespace tandem::client
