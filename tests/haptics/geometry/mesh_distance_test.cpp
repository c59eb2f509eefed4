// The distance of two meshes against closed forms and against every pair of triangles tested alone.

#include "haptics/geometry/mesh_distance.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "haptics/geometry/triangle_pair.h"
#include "tests/support/bench_meshes.h"
#include "tests/support/shapes.h"

namespace tandem::test {
namespace {

using haptics::MeshGap;
using haptics::nearestPoints;
using haptics::PlacedMesh;
using haptics::Triangle;
using haptics::TriangleBvh;

constexpr double kEverything = 1e300;
constexpr double kPairScales[] = {1e-3, 1.0, 20.0};

Pose turned(const glm::dvec3& position, const glm::dvec3& rotation) {
  return {position, fromRotationVector(rotation)};
}

TEST(MeshDistance, OfBoxesIsTheGapBetweenFacesAndBetweenEdges) {
  for (const double s : kPairScales) {
    const assets::Mesh box = boxMesh(glm::dvec3(s));
    const TriangleBvh tree(box, 1);
    MeshGap gap;
    ASSERT_TRUE(nearestPoints({&tree, {}}, {&tree, {{1.25 * s, 0.1 * s, 0.0}}}, kEverything, gap));
    EXPECT_NEAR(gap.distance, 0.25 * s, 1e-15 * s);
    EXPECT_NEAR(gap.onA.x, 0.5 * s, 1e-15 * s);
    EXPECT_NEAR(gap.onB.x, 0.75 * s, 1e-15 * s);
    // Two edges across each other, each on the line of centres.
    const Pose left = turned({0.0, 0.0, 0.0}, {0.0, 0.0, kPi / 4});
    const Pose right = turned({2.0 * s, 0.0, 0.0}, {0.0, kPi / 4, 0.0});
    ASSERT_TRUE(nearestPoints({&tree, left}, {&tree, right}, kEverything, gap));
    EXPECT_NEAR(gap.distance, (2.0 - std::sqrt(2.0)) * s, 1e-14 * s);
    EXPECT_NEAR(glm::length(gap.onA - glm::dvec3(std::sqrt(0.5) * s, 0.0, 0.0)), 0.0, 1e-14 * s);
    EXPECT_NEAR(glm::length(gap.onA - gap.onB), gap.distance, 1e-15 * s);
  }
}

TEST(MeshDistance, TellsNothingBeyondItsReach) {
  const assets::Mesh box = boxMesh(glm::dvec3(1.0));
  const TriangleBvh tree(box, 1);
  MeshGap gap;
  gap.distance = 7.0;
  const PlacedMesh a{&tree, {}}, b{&tree, {{1.25, 0.0, 0.0}}};
  EXPECT_FALSE(nearestPoints(a, b, 0.2499, gap));
  EXPECT_EQ(gap.distance, 7.0);
  EXPECT_TRUE(nearestPoints(a, b, 0.2501, gap));
  const assets::Mesh nothing;
  const TriangleBvh empty(nothing, 1);
  EXPECT_FALSE(nearestPoints(a, {&empty, {}}, kEverything, gap));
  EXPECT_FALSE(nearestPoints({&empty, {}}, a, kEverything, gap));
}

TEST(MeshDistance, IsZeroWhereSurfacesCrossAndNotWhereOneHoldsTheOther) {
  const assets::Mesh large = boxMesh(glm::dvec3(1.0)), small = boxMesh(glm::dvec3(0.2));
  const TriangleBvh outer(large, 1), inner(small, 1);
  MeshGap gap;
  ASSERT_TRUE(nearestPoints({&outer, {}}, {&inner, {{0.45, 0.0, 0.0}}}, kEverything, gap));
  EXPECT_EQ(gap.distance, 0.0);
  EXPECT_NEAR(glm::length(gap.onA - gap.onB), 0.0, 1e-15);
  ASSERT_TRUE(nearestPoints({&outer, {}}, {&inner, {{0.3, 0.0, 0.0}}}, kEverything, gap));
  EXPECT_NEAR(gap.distance, 0.1, 1e-15);
}

TEST(MeshDistance, OfSpheresIsThatOfTheirFacets) {
  for (const double s : kPairScales) {
    const assets::Mesh mesh = tests::sphereMesh(0.5 * s, 20'000, tests::Topology::never);
    const TriangleBvh tree(mesh);
    const Pose there = turned({1.5 * s, 0.7 * s, -0.2 * s}, {0.3, 1.0, -0.4});
    MeshGap gap;
    ASSERT_TRUE(nearestPoints({&tree, {}}, {&tree, there}, kEverything, gap));
    const double spheres = glm::length(there.position) - s, sag = tests::deepestFacet(mesh, 0.5 * s);
    EXPECT_GE(gap.distance, spheres - 1e-13 * s);
    EXPECT_LE(gap.distance, spheres + 2.0 * sag);
    EXPECT_LT(sag, 1e-3 * s);
  }
}

/// Triangles without area, slivers and ordinary ones within a cube of 2 m.
assets::Mesh dirtySoupOf(unsigned seed, int count, double scale) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> u(-1.0, 1.0);
  const auto some = [&] { return glm::dvec3(u(random), u(random), u(random)); };
  assets::Mesh mesh;
  for (int i = 0; i < count; ++i) {
    const double size = std::pow(10.0, -0.9 + 0.6 * u(random));
    const glm::dvec3 a = some(), b = i % 7 == 0 ? a : a + size * some();
    const glm::dvec3 c = i % 5 == 0 ? 0.5 * (a + b) + 1e-4 * size * some() : a + size * some();
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    for (const glm::dvec3& p : {a, b, c}) mesh.positions.push_back(p * scale);
    mesh.triangles.push_back({first, first + 1, first + 2});
  }
  return mesh;
}

double brutePairDistance(const PlacedMesh& a, const PlacedMesh& b) {
  double least = kEverything;
  const Pose aFromB = inverse(a.worldFromMesh) * b.worldFromMesh;
  std::vector<Triangle> others;
  for (std::uint32_t j = 0; j < b.tree->mesh().triangles.size(); ++j) {
    const Triangle t = b.tree->triangle(j);
    others.push_back({transformPoint(aFromB, t.a), transformPoint(aFromB, t.b), transformPoint(aFromB, t.c)});
  }
  for (std::uint32_t i = 0; i < a.tree->mesh().triangles.size(); ++i) {
    for (const Triangle& other : others) {
      least = std::min(least, haptics::nearestPoints(a.tree->triangle(i), other).square);
    }
  }
  return std::sqrt(least);
}

TEST(MeshDistance, OfRandomSoupsIsThatOfAllPairsOfTriangles) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> u(-1.0, 1.0);
  int meeting = 0;
  for (int i = 0; i < 18; ++i) {
    const double s = kPairScales[i % 3];
    const assets::Mesh left = dirtySoupOf(2 * i, 150, s), right = dirtySoupOf(2 * i + 1, 180, s);
    const TriangleBvh treeA(left, 1), treeB(right, 1);
    const glm::dvec3 home = i % 6 == 5 ? glm::dvec3(3e4, -1e4, 2e4) * s : glm::dvec3(0.0);
    const PlacedMesh a{&treeA, turned(home, {u(random), u(random), u(random)})};
    const double off = i % 2 == 0 ? 2.2 : 0.6;
    const PlacedMesh b{&treeB, turned(home + glm::dvec3(off * s, 0.3 * s, 0.0), {u(random), 2.0, u(random)})};
    const double expected = brutePairDistance(a, b);
    MeshGap gap, swapped;
    ASSERT_TRUE(nearestPoints(a, b, kEverything, gap));
    ASSERT_TRUE(nearestPoints(b, a, kEverything, swapped));
    EXPECT_NEAR(gap.distance, expected, 1e-14 * s) << i;
    EXPECT_NEAR(swapped.distance, expected, 1e-10 * s) << i;
    EXPECT_NEAR(glm::length(gap.onA - gap.onB), gap.distance, 1e-10 * s) << i;
    meeting += expected == 0.0 ? 1 : 0;
  }
  EXPECT_GT(meeting, 2);
  EXPECT_LT(meeting, 15);
}

}  // namespace
}  // namespace tandem::test
