#include "client/levels/render_mesh.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include <glm/geometric.hpp>

#include "assets/mesh/mesh_analysis.h"

namespace tandem::client {
namespace {

constexpr double kCrease = 0.5235987755982988;

assets::Mesh cube() {
  assets::TriangleSoup soup;
  for (int i = 0; i < 8; ++i)
    soup.positions.emplace_back((i & 1) ? 1.0 : 0.0, (i & 2) ? 1.0 : 0.0, (i & 4) ? 1.0 : 0.0);
  soup.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  for (std::size_t t = 0; t < 12; ++t) soup.triangleMaterial.push_back(t % 2 == 0 ? 1 : 0);
  return assets::analyseMesh(std::move(soup), kCrease).mesh;
}

/// An open tube of `sides` quads about z, radius 1, height 1.
assets::Mesh tube(std::uint32_t sides) {
  assets::TriangleSoup soup;
  for (std::uint32_t s = 0; s < sides; ++s)
    for (const double z : {0.0, 1.0}) {
      const double angle = 2.0 * std::numbers::pi * s / sides;
      soup.positions.emplace_back(std::cos(angle), std::sin(angle), z);
    }
  for (std::uint32_t s = 0; s < sides; ++s) {
    const std::uint32_t a = 2 * s, b = 2 * ((s + 1) % sides);
    soup.triangles.push_back({a, b, b + 1});
    soup.triangles.push_back({a, b + 1, a + 1});
    soup.triangleMaterial.insert(soup.triangleMaterial.end(), {0, 0});
  }
  return assets::analyseMesh(std::move(soup), kCrease).mesh;
}

TEST(RenderMesh, ACubeKeepsItsSharpCorners) {
  const RenderMesh mesh = makeRenderMesh(cube());
  EXPECT_EQ(mesh.vertices.size(), 24u);  // three normals a corner
  EXPECT_EQ(mesh.indices.size(), 36u);
  for (const RenderVertex& vertex : mesh.vertices) {
    const glm::vec3 n = glm::abs(vertex.normal);
    EXPECT_NEAR(std::max({n.x, n.y, n.z}), 1.0f, 1e-5f);
  }
}

TEST(RenderMesh, ACubeHasTwelveEdgesAndNoDiagonals) {
  const RenderMesh mesh = makeRenderMesh(cube());
  ASSERT_EQ(mesh.featureEdges.size(), 24u);
  for (std::size_t e = 0; e < 24; e += 2)
    EXPECT_NEAR(glm::distance(mesh.featureEdges[e], mesh.featureEdges[e + 1]), 1.0f, 1e-6f);
}

TEST(RenderMesh, TrianglesAreGroupedByMaterial) {
  const RenderMesh mesh = makeRenderMesh(cube());
  ASSERT_EQ(mesh.ranges.size(), 2u);
  EXPECT_EQ(mesh.ranges[0].material, 0);
  EXPECT_EQ(mesh.ranges[1].material, 1);
  EXPECT_EQ(mesh.ranges[0].indexCount + mesh.ranges[1].indexCount, 36u);
  EXPECT_EQ(mesh.ranges[1].firstIndex, mesh.ranges[0].indexCount);
}

TEST(RenderMesh, AFineTubeIsSmoothAndACoarseOneIsNot) {
  const RenderMesh fine = makeRenderMesh(tube(48));
  EXPECT_EQ(fine.vertices.size(), 96u);
  for (const RenderVertex& vertex : fine.vertices) {
    const glm::vec3 radial = glm::normalize(glm::vec3(vertex.position.x, vertex.position.y, 0.0f));
    EXPECT_GT(std::abs(glm::dot(vertex.normal, radial)), 0.9999f);
  }
  EXPECT_EQ(makeRenderMesh(tube(6)).vertices.size(),
            24u);  // 60 degrees between faces: each keeps its own normals
}

TEST(RenderMesh, AMeshWithoutTopologyIsDrawnFlat) {
  assets::Mesh mesh = cube();
  mesh.neighbours.clear();
  mesh.edgeFlags.clear();
  const RenderMesh flat = makeRenderMesh(mesh);
  EXPECT_EQ(flat.vertices.size(), 36u);
  EXPECT_TRUE(flat.featureEdges.empty());
}

TEST(RenderMesh, ShapesReachTheirStatedSizes) {
  using Kind = assets::ImplicitShape::Kind;
  assets::ImplicitShape shape;
  shape.partFromShape.position = {1.0, 2.0, 3.0};
  shape.size = {0.2, 0.4, 0.6};
  shape.height = 0.4;
  shape.radiusTop = shape.radiusBottom = 0.1;
  const struct {
    Kind kind;
    glm::dvec3 half;
  } cases[] = {{Kind::box, {0.1, 0.2, 0.3}},
               {Kind::sphere, {0.1, 0.1, 0.1}},
               {Kind::cylinder, {0.1, 0.2, 0.1}},
               {Kind::capsule, {0.1, 0.3, 0.1}},
               {Kind::plane, {0.1, 0.0, 0.3}}};
  for (const auto& expected : cases) {
    shape.kind = expected.kind;
    glm::dvec3 reach(0.0);
    for (const RenderVertex& vertex : makeRenderMesh(shape, 1.0).vertices) {
      reach = glm::max(reach, glm::abs(glm::dvec3(vertex.position) - shape.partFromShape.position));
      EXPECT_NEAR(glm::length(vertex.normal), 1.0f, 1e-5f);
    }
    EXPECT_NEAR(reach.x, expected.half.x, 1e-3) << static_cast<int>(expected.kind);
    EXPECT_NEAR(reach.y, expected.half.y, 1e-3) << static_cast<int>(expected.kind);
    EXPECT_NEAR(reach.z, expected.half.z, 1e-3) << static_cast<int>(expected.kind);
  }
}

}  // namespace
}  // namespace tandem::client
