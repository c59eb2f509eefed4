#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <random>

#include <glm/geometric.hpp>

#include "haptics/geometry/scene_bvh.h"
#include "haptics/geometry/triangle_bvh.h"
#include "tests/support/shapes.h"

namespace tandem::test {
namespace {

using haptics::MeshBallHit;
using haptics::MeshPoint;
using haptics::SceneBvh;
using haptics::Triangle;
using haptics::TriangleBvh;

/// A cloud of triangles of very different sizes, some without area, around `offset`.
assets::Mesh cloud(int count, const glm::dvec3& offset) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> u(-1.0, 1.0);
  assets::Mesh mesh;
  for (int i = 0; i < count; ++i) {
    const glm::dvec3 a = offset + glm::dvec3(u(random), u(random), u(random));
    const double size = std::pow(10.0, -2.0 + 2.0 * u(random));
    const glm::dvec3 b = a + size * glm::dvec3(u(random), u(random), u(random));
    const glm::dvec3 c =
        i % 5 == 0 ? a + 0.5 * (b - a) : a + size * glm::dvec3(u(random), u(random), u(random));
    for (const glm::dvec3& p : {a, b, c}) mesh.positions.push_back(p);
    const auto first = static_cast<std::uint32_t>(3 * i);
    mesh.triangles.push_back({first, first + 1, first + 2});
  }
  return mesh;
}

double bruteDistance(const TriangleBvh& tree, const glm::dvec3& p) {
  double best = 1e300;
  for (std::uint32_t i = 0; i < tree.mesh().triangles.size(); ++i) {
    best = std::min(best, glm::length(p - haptics::closestPointOnTriangle(p, tree.triangle(i)).point));
  }
  return best;
}

TEST(TriangleMath, ClosestPointIsNoFartherThanAnySample) {
  const assets::Mesh mesh = cloud(200, glm::dvec3(0.0));
  std::mt19937 random(5);
  std::uniform_real_distribution<double> u(-1.0, 1.0), s(0.0, 1.0);
  for (const auto& corner : mesh.triangles) {
    const Triangle t{mesh.positions[corner[0]], mesh.positions[corner[1]], mesh.positions[corner[2]]};
    const glm::dvec3 p(u(random), u(random), u(random));
    const double distance = glm::length(p - haptics::closestPointOnTriangle(p, t).point);
    for (int i = 0; i < 100; ++i) {
      double v = s(random), w = s(random);
      if (v + w > 1.0) v = 1.0 - v, w = 1.0 - w;
      ASSERT_LE(distance, glm::length(p - (t.a + v * (t.b - t.a) + w * (t.c - t.a))) + 1e-12);
    }
  }
}

TEST(TriangleMath, SweptBallStopsAtItsRadiusAndNeverBelow) {
  const assets::Mesh mesh = cloud(500, glm::dvec3(0.0));
  std::mt19937 random(9);
  std::uniform_real_distribution<double> u(-1.0, 1.0);
  int hits = 0;
  for (const auto& corner : mesh.triangles) {
    const Triangle t{mesh.positions[corner[0]], mesh.positions[corner[1]], mesh.positions[corner[2]]};
    const glm::dvec3 from = t.a + 2.0 * glm::dvec3(u(random), u(random), u(random));
    const glm::dvec3 motion = 2.0 * (t.a - from) + 0.1 * glm::dvec3(u(random), u(random), u(random));
    haptics::BallHit hit;
    const auto distanceAt = [&](double s) {
      const glm::dvec3 p = from + s * motion;
      return glm::length(p - haptics::closestPointOnTriangle(p, t).point);
    };
    if (distanceAt(0.0) <= 0.05) continue;
    const bool found = haptics::sweepBall(from, motion, 0.05, 1e-9, t, hit);
    hits += found ? 1 : 0;
    const double last = found ? hit.t : 1.0;
    for (int i = 0; i < 200; ++i) ASSERT_GE(distanceAt(last * i / 200.0), 0.05 - 1e-12);
    if (found) {
      ASSERT_NEAR(distanceAt(hit.t), 0.05, 1e-8);
    }
  }
  EXPECT_GT(hits, 300);
}

TEST(TriangleBvh, ClosestPointAgreesWithBruteForce) {
  for (const glm::dvec3& offset : {glm::dvec3(0.0), glm::dvec3(1e5, -2e5, 3e4)}) {
    const assets::Mesh mesh = cloud(3000, offset);
    const TriangleBvh tree(mesh, 2);
    std::mt19937 random(1);
    std::uniform_real_distribution<double> u(-1.5, 1.5);
    for (int i = 0; i < 300; ++i) {
      const glm::dvec3 p = offset + glm::dvec3(u(random), u(random), u(random));
      const double expected = bruteDistance(tree, p);
      MeshPoint found;
      ASSERT_TRUE(tree.closestPoint(p, 10.0, found));
      EXPECT_EQ(found.distance, expected);
      EXPECT_FALSE(tree.closestPoint(p, 0.99 * expected, found));
    }
  }
}

TEST(TriangleBvh, SweptBallAgreesWithBruteForce) {
  const assets::Mesh mesh = cloud(3000, glm::dvec3(0.0));
  const TriangleBvh tree(mesh, 2);
  std::mt19937 random(2);
  std::uniform_real_distribution<double> u(-1.5, 1.5);
  int hits = 0;
  for (int i = 0; i < 500; ++i) {
    const glm::dvec3 from(u(random), u(random), u(random));
    const glm::dvec3 motion =
        (i % 3 == 0 ? 0.01 : 1.0) * glm::dvec3(u(random), u(random), i % 7 == 0 ? 0.0 : u(random));
    const double radius = i % 2 == 0 ? 1e-9 : 0.01;
    MeshBallHit best, hit;
    bool expected = false;
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
      haptics::BallHit one;
      one.t = best.t;
      if (!haptics::sweepBall(from, motion, radius, 1e-10, tree.triangle(t), one)) continue;
      static_cast<haptics::BallHit&>(best) = one;
      expected = true;
    }
    ASSERT_EQ(tree.sweepBall(from, motion, radius, 1e-10, hit), expected) << i;
    hits += expected ? 1 : 0;
    if (expected) {
      EXPECT_EQ(hit.t, best.t) << i;
    }
  }
  EXPECT_GT(hits, 50);
}

TEST(TriangleBvh, GathersEveryTriangleInABox) {
  const assets::Mesh mesh = cloud(2000, glm::dvec3(0.0));
  const TriangleBvh tree(mesh, 1);
  std::vector<std::uint32_t> found(2000);
  const assets::Bounds box{{-0.2, -0.3, -0.1}, {0.3, 0.1, 0.4}};
  found.resize(tree.gather(box, found));
  std::sort(found.begin(), found.end());
  std::size_t expected = 0;
  for (std::uint32_t i = 0; i < 2000; ++i) {
    const Triangle t = tree.triangle(i);
    const assets::Bounds own{glm::min(t.a, glm::min(t.b, t.c)), glm::max(t.a, glm::max(t.b, t.c))};
    if (!SceneBvh::meet(own, box)) continue;
    ++expected;
    EXPECT_TRUE(std::binary_search(found.begin(), found.end(), i));
  }
  EXPECT_GT(expected, 10u);
  EXPECT_LE(found.size(), expected + mesh.triangles.size() / 5);  // leaves hold up to four
  std::uint32_t few[3];
  EXPECT_EQ(tree.gather(box, few), found.size());  // what does not fit is still counted
}

TEST(TriangleBvh, IsTheSameTreeForAnyNumberOfThreads) {
  const assets::Mesh mesh = cloud(40'000, glm::dvec3(0.0));
  const TriangleBvh one(mesh, 1), four(mesh, 4);
  EXPECT_EQ(one.memory(), four.memory());
  std::vector<std::uint32_t> a(40'000), b(40'000);
  const assets::Bounds all{glm::dvec3(-9.0), glm::dvec3(9.0)};
  ASSERT_EQ(one.gather(all, a), 40'000u);
  ASSERT_EQ(four.gather(all, b), 40'000u);
  EXPECT_EQ(a, b);  // in leaf order
}

TEST(TriangleBvh, StaysShallowForCoincidentTriangles) {
  assets::Mesh mesh;
  mesh.positions = {{0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}};
  mesh.triangles.assign(10'000, {0, 1, 2});
  const TriangleBvh tree(mesh, 1);
  EXPECT_LE(tree.depth(), 14);
  MeshPoint found;
  ASSERT_TRUE(tree.closestPoint({0.2, 0.2, 0.5}, 1.0, found));
  EXPECT_EQ(found.distance, 0.5);
  EXPECT_EQ(found.triangle, 0u);
}

TEST(TriangleBvh, EmptyMeshFindsNothing) {
  const assets::Mesh mesh;
  const TriangleBvh tree(mesh, 1);
  MeshPoint found;
  MeshBallHit hit;
  EXPECT_FALSE(tree.closestPoint(glm::dvec3(0.0), 1e9, found));
  EXPECT_FALSE(tree.sweepBall(glm::dvec3(0.0), glm::dvec3(1.0), 1.0, 0.1, hit));
  EXPECT_EQ(tree.signedCrossings(glm::dvec3(0.0), glm::dvec3(1.0)), 0);
}

TEST(TriangleBvh, CrossingsTellInsideFromOutside) {
  const assets::Mesh mesh = sphereMesh(1.0, 20);
  const TriangleBvh tree(mesh, 1);
  const glm::dvec3 path(3.0, 0.41, 0.73);
  EXPECT_EQ(tree.signedCrossings({0.1, 0.2, -0.3}, glm::dvec3(0.1, 0.2, -0.3) + path), 1);
  EXPECT_EQ(tree.signedCrossings({-1.5, -0.1, -0.2}, glm::dvec3(-1.5, -0.1, -0.2) + path), 0);
}

TEST(SceneBvh, AgreesWithBruteForceAfterPartsHaveMoved) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> u(-1.0, 1.0);
  const auto someBox = [&] {
    const glm::dvec3 p(u(random), u(random), u(random));
    return assets::Bounds{p, p + glm::dvec3(0.05)};
  };
  std::vector<assets::Bounds> boxes(300);
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    if (i % 10 != 0) boxes[i] = someBox();  // every tenth part has no geometry
  }
  SceneBvh tree(boxes);
  for (int round = 0; round < 50; ++round) {
    const auto part = static_cast<PartId>(random() % 300);
    if (part % 10 != 0) {
      boxes[part] = someBox();
      tree.update(part, boxes[part]);
    }
    assets::Bounds query = someBox();
    query.max += 0.4;
    std::vector<PartId> found, expected;
    tree.forEach(query, [&](PartId p) { found.push_back(p); });
    std::sort(found.begin(), found.end());
    for (std::size_t i = 0; i < boxes.size(); ++i) {
      if (SceneBvh::meet(boxes[i], query)) expected.push_back(static_cast<PartId>(i));
    }
    ASSERT_EQ(found, expected);
  }
}

}  // namespace
}  // namespace tandem::test
