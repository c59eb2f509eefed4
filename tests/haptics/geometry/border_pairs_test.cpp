#include "haptics/geometry/border_pairs.h"

#include <gtest/gtest.h>

#include <cmath>

#include <glm/geometric.hpp>

#include "haptics/geometry/mesh_edges.h"
#include "tests/support/part_meshes.h"
#include "tests/support/t_junction_meshes.h"

namespace tandem::test {
namespace {

using haptics::facesBeyondBorders;
using haptics::MeshEdge;
using haptics::MeshEdges;

constexpr double kBorderScales[] = {1e-3, 1.0, 1e3};
constexpr double kRight = 1.5707963267948966;

/// A box whose six faces stand off by `off` along their normals, their edges cut at places of their own.
assets::Mesh explodedBox(double off, double scale) {
  const EdgeCuts cuts{.seed = 3, .share = 0.6, .most = 2, .bothSides = true};
  assets::TriangleSoup soup = withTJunctions(boxSoup(glm::dvec3(1.0, 0.8, 0.6), 2), cuts);
  for (const auto& t : soup.triangles) {
    const glm::dvec3 a = soup.positions[t[0]], b = soup.positions[t[1]], c = soup.positions[t[2]];
    const glm::dvec3 up = off * glm::normalize(glm::cross(b - a, c - a));
    for (const std::uint32_t v : t) soup.positions[v] += up;
  }
  return meshOf(placed(soup, turnOf(5), scale, glm::dvec3(0.0)));
}

TEST(BorderPairs, OfAClosedMeshAreNone) {
  EXPECT_TRUE(facesBeyondBorders(meshOf(boxSoup(glm::dvec3(1.0), 3)), 0.1).empty());
}

TEST(BorderPairs, MakeTheEdgesOfTheClosedMeshAcrossSlits) {
  for (const double scale : kBorderScales)
    for (const double off : {2e-6, 2e-5}) {
      const assets::Mesh mesh = explodedBox(off, scale);
      ASSERT_FALSE(mesh.closed);
      const MeshEdges edges(mesh);
      for (std::uint32_t e = 0; e < edges.count(); ++e) {
        const MeshEdge edge = edges.edge(e);
        EXPECT_TRUE(edge.border);
        EXPECT_NE(edge.triangles[0], edge.triangles[1]);
        EXPECT_NEAR(edge.angle, kRight, 1e-3) << off;
      }
    }
}

/// Wider than a slit, a border has the back of its face as a sheet's, and ends its face as a solid's.
TEST(BorderPairs, AreNoneAcrossAWideHole) {
  for (const double scale : kBorderScales) {
    const assets::Mesh mesh = explodedBox(1e-3, scale);
    MeshEdges edges(mesh);
    ASSERT_GT(edges.count(), 0u);
    for (std::uint32_t e = 0; e < edges.count(); ++e) {
      const MeshEdge edge = edges.edge(e);
      EXPECT_EQ(edge.triangles[0], edge.triangles[1]);
      EXPECT_NEAR(edge.angle, 2.0 * kRight, 1e-12);
    }
    const MeshEdges closed = std::move(edges).ofSolid();
    for (std::uint32_t e = 0; e < closed.count(); ++e) {
      const MeshEdge edge = closed.edge(e);
      EXPECT_NEAR(edge.angle, kRight, 1e-12);
      EXPECT_NEAR(glm::dot(edge.normals[0], edge.normals[1]), 0.0, 1e-12);
      // The plane in which the face ends looks away from it, that is from the middle of the box.
      EXPECT_GT(glm::dot(edge.normals[1], 0.5 * (edge.a + edge.b)), 0.0);
    }
  }
}

}  // namespace
}  // namespace tandem::test
