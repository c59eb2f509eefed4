// Sweeps that remember the last one must find what the tree finds, to the bit.

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include <glm/geometric.hpp>

#include "haptics/geometry/query_work.h"
#include "haptics/geometry/sweep_front.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/bench_meshes.h"

namespace tandem::test {
namespace {

using haptics::MeshBallHit;
using haptics::SweepFront;
using haptics::TriangleBvh;

bool same(bool foundA, const MeshBallHit& a, bool foundB, const MeshBallHit& b) {
  if (foundA != foundB || a.t != b.t) return false;
  return !foundA || (a.triangle == b.triangle && a.point == b.point && a.normal == b.normal);
}

/// A ball that goes as a proxy does: most sweeps go on from where the last one stopped, many towards the
/// inside; now and then it jumps, or its radius changes.
struct Walk {
  int differences = 0, hits = 0;
  std::uint64_t nodesOfTree = 0, nodesOfFront = 0;
};

Walk walk(const assets::Mesh& mesh, double scale, double radius, int steps, float exaggeration = 0.0f) {
  const TriangleBvh tree(mesh, 1);
  SweepFront front;
  front.exaggerate(exaggeration);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> u(-1.0, 1.0);
  const auto vector = [&] {
    const double x = u(random), y = u(random), z = u(random);
    return glm::dvec3(x, y, z);
  };
  Walk result;
  glm::dvec3 p(0.0, 0.0, 2.0 * scale);
  const double skin = 1e-9 * scale;
  for (int i = 0; i < steps; ++i) {
    if (i % 97 == 0) {
      const auto t = static_cast<std::uint32_t>(random() % mesh.triangles.size());
      p = tree.triangle(t).a * (1.0 + 1e-3 * u(random)) + (radius + 1e-3 * scale) * glm::normalize(vector());
    }
    const double length = scale * std::pow(10.0, -2.5 + 1.5 * u(random));
    const glm::dvec3 inwards = glm::length(p) > 0.0 ? -glm::normalize(p) : glm::dvec3(0.0);
    const glm::dvec3 motion = length * glm::normalize(vector() + 0.5 * inwards);
    MeshBallHit byTree, byFront;
    byTree.t = byFront.t = i % 11 == 0 ? 0.4 : 1.0;
    const haptics::QueryWork start = haptics::queryWork;
    const bool one = tree.sweepBall(p, motion, radius + skin, 0.1 * skin, byTree);
    const haptics::QueryWork middle = haptics::queryWork;
    const AllocationScope scope;
    const bool two = front.sweepBall(tree, p, motion, radius + skin, 0.1 * skin, byFront);
    EXPECT_EQ(scope.count(), 0u);
    result.nodesOfTree += (middle - start).nodes;
    result.nodesOfFront += (haptics::queryWork - middle).nodes;
    result.differences += same(one, byTree, two, byFront) ? 0 : 1;
    result.hits += one ? 1 : 0;
    p += motion * (one ? 0.999 * byTree.t : byTree.t);
    if (glm::length(p) > 3.0 * scale) p = 1.5 * scale * glm::normalize(p);
  }
  return result;
}

std::vector<assets::Mesh> meshesAt(double scale) {
  std::vector<assets::Mesh> meshes{tests::scanMesh(scale, 6000, 0.05, 1),
                                   tests::scanMesh(scale, 6000, 0.4, 2), tests::gearMesh(4000)};
  for (glm::dvec3& p : meshes[2].positions) p *= 45.0 * scale;
  return meshes;
}

TEST(SweepFront, FindsWhatTheTreeFindsAtEveryScaleAndSize) {
  for (const double scale : {1.0, 1e-3, 20.0}) {
    for (const assets::Mesh& mesh : meshesAt(scale)) {
      for (const double radius : {0.0, 0.01, 0.1}) {
        const Walk result = walk(mesh, scale, radius * scale, 1500);
        EXPECT_EQ(result.differences, 0) << scale << " " << radius;
        EXPECT_GT(result.hits, 150);
        EXPECT_LE(result.nodesOfFront, result.nodesOfTree) << scale << " " << radius;
      }
    }
  }
}

TEST(SweepFront, LeavesABallOverMoreTrianglesThanItHasRoomForToTheTree) {
  const Walk result = walk(tests::scanMesh(1.0, 6000, 0.05, 1), 1.0, 0.5, 300);
  EXPECT_EQ(result.differences, 0);
  EXPECT_LT(result.nodesOfFront, 2 * result.nodesOfTree);
}

TEST(SweepFront, WhoseProofsClaimTooMuchIsFoundOut) {
  for (const assets::Mesh& mesh : meshesAt(1.0)) EXPECT_GT(walk(mesh, 1.0, 0.1, 1500, 0.05f).differences, 0);
}

TEST(SweepFront, GoesOverToAnotherTreeAndForgets) {
  assets::Mesh mesh = tests::sphereMesh(1.0, 500);
  const assets::Mesh other = tests::sphereMesh(1.2, 500);
  TriangleBvh tree(mesh, 1);
  const TriangleBvh second(other, 1);
  SweepFront front;
  const glm::dvec3 from(0.0, 0.0, 2.0), motion(0.0, 0.0, -2.0);
  MeshBallHit hit;
  ASSERT_TRUE(front.sweepBall(tree, from, motion, 0.1, 1e-9, hit));
  EXPECT_NEAR(hit.t, 0.45, 0.01);
  hit = {};
  ASSERT_TRUE(front.sweepBall(second, from, motion, 0.1, 1e-9, hit));
  EXPECT_NEAR(hit.t, 0.35, 0.01);
  for (glm::dvec3& p : mesh.positions) p *= 1.5;
  tree.refit(1);
  front.forget();
  hit = {};
  ASSERT_TRUE(front.sweepBall(tree, from, motion, 0.1, 1e-9, hit));
  EXPECT_NEAR(hit.t, 0.2, 0.01);
}

}  // namespace
}  // namespace tandem::test
