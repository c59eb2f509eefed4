// Meshes smaller than any float has digits for, and larger than any float: nothing to feel, nothing to crash.

#include <gtest/gtest.h>

#include <limits>
#include <random>

#include <glm/geometric.hpp>

#include "haptics/geometry/triangle_bvh.h"

namespace tandem::test {
namespace {

using haptics::TriangleBvh;

/// A cloud of triangles that spans `span` along each axis; flat along z if `flat`.
assets::Mesh cloudAcross(double span, bool flat) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> u(-0.5, 0.5);
  assets::Mesh mesh;
  for (std::uint32_t i = 0; i < 300; ++i) {
    for (int corner = 0; corner < 3; ++corner) {
      mesh.positions.push_back(span * glm::dvec3(u(random), u(random), flat ? 0.0 : u(random)));
    }
    mesh.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  return mesh;
}

double leastDistance(const TriangleBvh& tree, const glm::dvec3& p) {
  double least = std::numeric_limits<double>::infinity();
  for (std::uint32_t i = 0; i < tree.mesh().triangles.size(); ++i) {
    least = std::min(least, glm::length(p - haptics::closestPointOnTriangle(p, tree.triangle(i)).point));
  }
  return least;
}

TEST(ExtremeMesh, OfDenormalSizeIsBuiltAndAnswersAsBruteForce) {
  for (const double span : {1e-39, 1e-36, 1e-30, 1e-20}) {
    for (const bool flat : {false, true}) {
      const assets::Mesh mesh = cloudAcross(span, flat);
      TriangleBvh tree(mesh, 1);
      for (int pass = 0; pass < 2; ++pass) {
        for (const glm::dvec3& direction : {glm::dvec3(0.0, 0.0, 1.0), glm::dvec3(0.3, -0.2, 0.1)}) {
          haptics::MeshPoint found;
          ASSERT_TRUE(tree.closestPoint(span * direction, 10.0 * span, found)) << span;
          EXPECT_EQ(found.distance, leastDistance(tree, span * direction)) << span;
        }
        tree.refit(1);
      }
    }
  }
}

TEST(ExtremeMesh, BeyondWhatAFloatHoldsIsBuiltWithAllItsTriangles) {
  for (const double span : {1e25, 1e31, 1e38, 1e39, 1e300}) {
    for (const bool flat : {false, true}) {
      const assets::Mesh mesh = cloudAcross(span, flat);
      TriangleBvh tree(mesh, 1);
      EXPECT_LE(tree.depth(), 20) << span;
      tree.refit(1);
      haptics::MeshPoint found;
      if (tree.closestPoint(mesh.positions[3], span, found)) {
        EXPECT_LT(found.triangle, mesh.triangles.size());
      }
      haptics::MeshBallHit hit;
      if (tree.sweepBall(glm::dvec3(span), glm::dvec3(-2.0 * span), 0.0, 1e-9, hit)) {
        EXPECT_LT(hit.triangle, mesh.triangles.size());
      }
    }
  }
}

}  // namespace
}  // namespace tandem::test
