// Overlaps whose depth is known: crossing, touching, contained, sheets, shells turned inside out.

#include "haptics/overlap/mesh_overlap.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "haptics/geometry/triangle_math.h"
#include "haptics/measure/penetration.h"
#include "tests/support/bench_meshes.h"
#include "tests/support/part_meshes.h"
#include "tests/support/shapes.h"
#include "tests/support/winding_number.h"

namespace tandem::test {
namespace {

using haptics::Meeting;
using haptics::MeshOverlap;
using haptics::overlapOf;
using haptics::PlacedMesh;
using haptics::TriangleBvh;

constexpr double kScales[] = {1e-3, 1.0, 20.0};

Pose turned(const glm::dvec3& position, const glm::dvec3& rotation) {
  return {position, fromRotationVector(rotation)};
}

/// Two boxes of the same orientation, the second offset by `offset` in their axes.
MeshOverlap boxes(const glm::dvec3& sizeA, const glm::dvec3& sizeB, const glm::dvec3& offset) {
  const assets::Mesh a = boxMesh(sizeA), b = boxMesh(sizeB);
  const TriangleBvh treeA(a, 1), treeB(b, 1);
  const Pose home = turned(sizeA * 3.0, {0.3, -0.7, 0.2});
  return overlapOf({&treeA, home}, {&treeB, home * Pose{offset}});
}

TEST(MeshOverlap, IsAsDeepAsABoxStandsInAnother) {
  for (const double s : kScales) {
    for (const double depth : {0.3, 1e-2, 1e-4}) {
      const MeshOverlap found =
          boxes(glm::dvec3(2.0, 3.0, 3.0) * s, glm::dvec3(1.0) * s, {(1.5 - depth) * s, 0.1 * s, 0.2 * s});
      EXPECT_EQ(found.meeting, Meeting::crossing);
      EXPECT_NEAR(found.depth, depth * s, 1e-13 * s);
      EXPECT_NEAR(glm::length(found.exitPath), depth * s, 1e-13 * s);
    }
  }
}

TEST(MeshOverlap, TellsFlushFacesFromClashesByAMillionthOfTheSize) {
  for (const double s : kScales) {
    const glm::dvec3 large = glm::dvec3(2.0, 3.0, 3.0) * s, small = glm::dvec3(1.0) * s;
    const double diagonal = std::sqrt(22.0) * s;
    const auto meeting = [&](double depth) {
      return boxes(large, small, {1.5 * s - depth, 0.1 * s, 0.0}).meeting;
    };
    EXPECT_EQ(meeting(0.0), Meeting::touching);
    EXPECT_EQ(meeting(0x1p-21 * diagonal), Meeting::touching);
    EXPECT_EQ(meeting(-0x1p-21 * diagonal), Meeting::touching);
    EXPECT_EQ(meeting(0x1p-18 * diagonal), Meeting::crossing);
    EXPECT_EQ(meeting(-0x1p-18 * diagonal), Meeting::apart);
  }
}

TEST(MeshOverlap, TellsFlushFacesOfEqualBoxesAndEdgesOnEdges) {
  const glm::dvec3 one(1.0);
  EXPECT_EQ(boxes(one, one, {1.0, 0.0, 0.0}).meeting, Meeting::touching);
  EXPECT_EQ(boxes(one, one, {1.0, 1.0, 0.0}).meeting, Meeting::touching);
  EXPECT_EQ(boxes(one, one, {1.0, 1.0, 1.0}).meeting, Meeting::touching);
  EXPECT_EQ(boxes(one, one, {1.0, 0.25, 0.5}).meeting, Meeting::touching);
  EXPECT_EQ(boxes(one, one, {1.01, 0.25, 0.5}).meeting, Meeting::apart);
}

TEST(MeshOverlap, FindsBarsThatCrossWithoutACornerInside) {
  for (const double s : kScales) {
    // The diagonal of a wide face of the thin bar runs through the middle of the thick one.
    const MeshOverlap found = boxes(glm::dvec3(10.0, 1.0, 1.0) * s, glm::dvec3(0.2, 0.4, 10.0) * s, {});
    EXPECT_EQ(found.meeting, Meeting::crossing);
    EXPECT_LE(found.depth, 0.5 * s * (1.0 + 1e-12));
    EXPECT_GE(found.depth, 0.5 * s * (1.0 - 1e-6));
    EXPECT_TRUE(found.inA);
  }
}

TEST(MeshOverlap, FindsASmallPartInsideALargeOneThoughNoSurfacesCross) {
  for (const double s : kScales) {
    const MeshOverlap found = boxes(glm::dvec3(60.0) * s, glm::dvec3(5.0) * s, {10.0 * s, 0.0, 0.0});
    EXPECT_EQ(found.meeting, Meeting::contained);
    EXPECT_NEAR(found.depth, 22.5 * s, 1e-6 * 22.5 * s);
    const MeshOverlap swapped = boxes(glm::dvec3(5.0) * s, glm::dvec3(60.0) * s, {10.0 * s, 0.0, 0.0});
    EXPECT_EQ(swapped.meeting, Meeting::contained);
    EXPECT_TRUE(found.inA);
    EXPECT_FALSE(swapped.inA);
  }
}

TEST(MeshOverlap, FindsAPartThatIsThereTwice) {
  for (const double s : kScales) {
    const glm::dvec3 size = glm::dvec3(1.0, 2.0, 3.0) * s;
    const MeshOverlap found = boxes(size, size, {});
    EXPECT_NE(found.meeting, Meeting::touching);
    EXPECT_NEAR(found.depth, 0.5 * s, 1e-5 * s) << "the ball that the box holds";
    const assets::Mesh box = boxMesh(size);
    const TriangleBvh tree(box, 1);
    const Pose there = turned(size, {1.0, 2.0, 3.0});
    EXPECT_EQ(overlapOf({&tree, there}, {&tree, there}).meeting, Meeting::crossing);
    EXPECT_NEAR(overlapOf({&tree, there}, {&tree, there}).depth, found.depth, 1e-6 * s);
    // Pushed along itself: all sides but the ends are flush.
    const MeshOverlap pushed = boxes(size, size, {0.0, 0.0, 0.5 * s});
    EXPECT_EQ(pushed.meeting, Meeting::crossing);
    EXPECT_NEAR(pushed.depth, 0.5 * s, 1e-6 * s);
  }
}

/// A plate of 0.2 whose top has a hole of half its width.
assets::Mesh plateWithAHole() {
  assets::TriangleSoup soup = boxSoup({1.0, 1.0, 0.2}, 4);
  std::erase_if(soup.triangles, [&](const auto& t) {
    const glm::dvec3 middle = (soup.positions[t[0]] + soup.positions[t[1]] + soup.positions[t[2]]) / 3.0;
    return middle.z > 0.09 && std::abs(middle.x) < 0.25 && std::abs(middle.y) < 0.25;
  });
  soup.triangleMaterial.resize(soup.triangles.size());
  return meshOf(soup);
}

TEST(MeshOverlap, OfAnOpenPartThatIsThereTwiceIsAtLeastWhatItsSurfaceHolds) {
  const assets::Mesh plate = plateWithAHole();
  ASSERT_FALSE(plate.closed);
  const TriangleBvh tree(plate, 1);
  for (const double off : {0.0, 1e-9, 1e-7}) {
    const MeshOverlap found = overlapOf({&tree, {}}, {&tree, {{off, off, 0.0}}});
    EXPECT_EQ(found.meeting, Meeting::crossing);
    EXPECT_TRUE(found.open) << "balls reach out of the hole";
    EXPECT_FALSE(found.sheets);
    EXPECT_NEAR(found.depth, 0.1, 1e-6) << off;
    EXPECT_GT(std::abs(windingNumber(plate, found.deepest)), 0.75) << off;
  }
}

/// Facets around a saddle point stand on both sides of each other's planes, and meet in one point.
TEST(MeshOverlap, OfAnOpenPartThatIsThereTwiceIsNotThatOfItsFacetsAtTheirCorners) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> u(-1.0, 1.0);
  for (int i = 0; i < 60; ++i) {
    assets::TriangleSoup soup = sphereSoup(0.5, 7);
    for (glm::dvec3& p : soup.positions) p *= (1.0 + 0.2 * u(random)) * glm::dvec3(1.0, 0.05, 0.5);
    std::erase_if(soup.triangles, [&](const auto& t) { return soup.positions[t[0]].x > 0.35; });
    soup.triangleMaterial.resize(soup.triangles.size());
    const assets::Mesh shell = meshOf(soup);
    for (glm::dvec3& p : soup.positions) p += 3e-8 * glm::dvec3(u(random), u(random), u(random));
    const assets::Mesh again = meshOf(soup);  // as rounded elsewhere
    const TriangleBvh tree(shell, 1), treeAgain(again, 1);
    const MeshOverlap found = overlapOf({&tree, {}}, {&treeAgain, {}});
    EXPECT_EQ(found.meeting, Meeting::crossing) << i;
    EXPECT_FALSE(found.sheets) << i;
    EXPECT_GT(found.depth, 0.01) << i;
  }
}

TEST(MeshOverlap, FindsASmallOverlapAmongManyFlushFaces) {
  // Flush everywhere but for a pin of a hundredth that stands out of one of them.
  const assets::Mesh floor = meshOf(boxSoup({1.0, 1.0, 0.1}, 14));
  const assets::Mesh plate = meshOf(joined(moved(boxSoup({1.0, 1.0, 0.1}, 14), {0.0, 0.0, 0.1}),
                                           moved(boxSoup({0.01, 0.01, 0.05}), {0.31, 0.17, 0.055})));
  const TriangleBvh treeA(floor, 1), treeB(plate, 1);
  const MeshOverlap found = overlapOf({&treeA, {}}, {&treeB, {}});
  EXPECT_EQ(found.meeting, Meeting::crossing);
  EXPECT_NEAR(found.depth, 0.02, 1e-6);
}

/// The same triangles, seen from the other side.
assets::Mesh turnedOver(assets::Mesh mesh) {
  for (auto& t : mesh.triangles) std::swap(t[0], t[1]);
  return mesh;
}

TEST(MeshOverlap, DoesNotAskWhichSideOfAShellIsOutside) {
  const assets::Mesh large = turnedOver(boxMesh(glm::dvec3(3.0))),
                     small = turnedOver(boxMesh(glm::dvec3(1.0)));
  const TriangleBvh treeA(large, 1), treeB(small, 1);
  const auto at = [&](double x) { return overlapOf({&treeA, {}}, {&treeB, {{x, 0.1, 0.2}}}); };
  EXPECT_EQ(at(0.0).meeting, Meeting::contained);
  EXPECT_EQ(at(1.9).meeting, Meeting::crossing);
  EXPECT_NEAR(at(1.9).depth, 0.1, 1e-14);
  EXPECT_EQ(at(2.0).meeting, Meeting::touching);
  EXPECT_EQ(at(2.1).meeting, Meeting::apart);
}

TEST(MeshOverlap, SaysThatSheetsHaveNoInside) {
  const assets::Mesh sheet = sheetMesh(1.0, 1), box = boxMesh(glm::dvec3(1.0));
  const TriangleBvh tree(sheet, 1), solid(box, 1);
  const Pose upright = turned({0.0, 0.0, 0.4}, {0.5 * kPi, 0.0, 0.0});
  const MeshOverlap found = overlapOf({&tree, {}}, {&tree, upright});
  EXPECT_EQ(found.meeting, Meeting::crossing);
  EXPECT_TRUE(found.sheets && found.open);
  EXPECT_NEAR(found.depth, 0.1, 1e-14);
  EXPECT_EQ(overlapOf({&tree, {}}, {&tree, turned({0.0, 0.0, 0.5}, {0.5 * kPi, 0.0, 0.0})}).meeting,
            Meeting::touching);
  const MeshOverlap inSolid = overlapOf({&tree, {{0.0, 0.0, 0.3}}}, {&solid, {}});
  EXPECT_FALSE(inSolid.sheets);
  EXPECT_FALSE(inSolid.inA);
}

TEST(MeshOverlap, IsAsDeepAsSpheresAre) {
  for (const double s : kScales) {
    const assets::Mesh mesh = tests::sphereMesh(0.5 * s, 8000);
    const TriangleBvh tree(mesh, 1);
    const double sag = tests::deepestFacet(mesh, 0.5 * s);
    const MeshOverlap found =
        overlapOf({&tree, {}}, {&tree, turned({0.7 * s, 0.4 * s, 0.0}, {1.0, 2.0, 3.0})});
    const double depth = s - std::hypot(0.7, 0.4) * s;
    EXPECT_EQ(found.meeting, Meeting::crossing);
    EXPECT_LE(found.depth, depth + 1e-12 * s);
    EXPECT_GE(found.depth, depth / 1.01 - 2.0 * sag);
  }
}

TEST(MeshOverlap, FitsOfOneTessellationTouchAndOfAnotherClashByTheSag) {
  // A pin in a bore of the same radius, both as many-sided: flush while the corners agree.
  const auto ring = [](double radius, int sides, double height, bool hole) {
    ShapeBuilder b;
    for (int i = 0; i < sides; ++i) {
      const double angle = 2.0 * kPi * i / sides;
      b.vertex(radius * std::cos(angle), radius * std::sin(angle), -0.5 * height);
      b.vertex(radius * std::cos(angle), radius * std::sin(angle), 0.5 * height);
      const double wall = hole ? 2.0 * radius : 0.0;
      b.vertex(wall * std::cos(angle), wall * std::sin(angle), -0.5 * height);
      b.vertex(wall * std::cos(angle), wall * std::sin(angle), 0.5 * height);
    }
    for (int i = 0; i < sides; ++i) {
      const auto p = static_cast<std::uint32_t>(4 * i), q = static_cast<std::uint32_t>(4 * ((i + 1) % sides));
      if (!hole) {
        b.quad(p, q, q + 1, p + 1);
        b.triangle(p, p + 2, q);
        b.triangle(p + 1, q + 1, p + 3);
      } else {
        b.quad(p, p + 1, q + 1, q);
        b.quad(p + 2, q + 2, q + 3, p + 3);
        b.quad(p, q, q + 2, p + 2);
        b.quad(p + 1, p + 3, q + 3, q + 1);
      }
    }
    return b.mesh();
  };
  const assets::Mesh pin = ring(1.0, 32, 4.0, false), bore = ring(1.0, 32, 1.0, true);
  const TriangleBvh tree(pin, 1), solid(bore, 1);
  EXPECT_TRUE(pin.closed && bore.closed);
  EXPECT_EQ(overlapOf({&tree, {}}, {&solid, {}}).meeting, Meeting::touching);
  const MeshOverlap rotated = overlapOf({&tree, turned({}, {0.0, 0.0, kPi / 32})}, {&solid, {}});
  EXPECT_EQ(rotated.meeting, Meeting::crossing);
  EXPECT_NEAR(rotated.depth, 1.0 - std::cos(kPi / 32), 1e-12);
}

double bruteDepth(const TriangleBvh& tree, const glm::dvec3& p) {
  if (std::abs(windingNumber(tree.mesh(), p)) < 0.5) return 0.0;
  double least = 1e300;
  for (std::uint32_t i = 0; i < tree.mesh().triangles.size(); ++i) {
    least = std::min(least, glm::length(haptics::closestPointOnTriangle(p, tree.triangle(i)).point - p));
  }
  return least;
}

TEST(MeshOverlap, OfRandomPlacesIsTheDeepestOfManyPointsTestedAlone) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> u(-1.0, 1.0);
  test::SpurGear small;
  small.flankPoints = 3;
  const assets::Mesh gear = meshOf(spurGearSoup(small));
  const assets::Mesh stair = meshOf(stairSoup(3, 0.01, 0.006, 0.03));
  const TriangleBvh treeA(gear, 1), treeB(stair, 1);
  const haptics::DepthModel modelA(gear), modelB(stair);
  int crossing = 0;
  for (int i = 0; i < 12; ++i) {
    const Pose worldFromA = turned({0.0, 0.0, 0.0}, {u(random), u(random), u(random)});
    const Pose worldFromB =
        turned(glm::dvec3(u(random), u(random), u(random)) * 0.025, {u(random), u(random), u(random)});
    const MeshOverlap found = overlapOf({&treeA, worldFromA}, {&treeB, worldFromB});
    double deepest = 0.0;
    for (int side = 0; side < 2; ++side) {
      const TriangleBvh &mesh = side == 0 ? treeA : treeB, &solid = side == 0 ? treeB : treeA;
      const Pose aFromB = inverse(worldFromA) * worldFromB,
                 otherFromOwn = side == 0 ? inverse(aFromB) : aFromB;
      for (std::uint32_t t = 0; t < mesh.mesh().triangles.size(); ++t) {
        const haptics::Triangle triangle = mesh.triangle(t);
        for (int k = 0; k < 4; ++k) {
          double v = 0.5 + 0.5 * u(random), w = 0.5 + 0.5 * u(random);
          if (v + w > 1.0) v = 1.0 - v, w = 1.0 - w;
          const glm::dvec3 p = triangle.a + (triangle.b - triangle.a) * v + (triangle.c - triangle.a) * w;
          deepest = std::max(deepest, bruteDepth(solid, transformPoint(otherFromOwn, p)));
        }
      }
    }
    ASSERT_GE(found.depth + 1e-8, deepest) << i;
    // Another search for the same depth.
    const double other = haptics::deepestPenetration(modelA, worldFromA, modelB, worldFromB).depth;
    ASSERT_NEAR(found.depth, other, 0.015 * other + 1e-8) << i;
    if (found.meeting != Meeting::crossing) continue;
    ++crossing;
    // The deepest point is as deep as the reported depth.
    const PlacedMesh in = found.inA ? PlacedMesh{&treeA, worldFromA} : PlacedMesh{&treeB, worldFromB};
    const glm::dvec3 p = transformPoint(inverse(in.worldFromMesh), found.deepest);
    EXPECT_NEAR(bruteDepth(*in.tree, p), found.depth, 1e-12) << i;
  }
  EXPECT_GT(crossing, 4);
}

TEST(MeshOverlap, IsNotMisledWhereFacesNearlyCoincide) {
  // A plank lies on the first tread of a stair, within rounding, juts out over its edge and stands in the
  // second step: one face is outside, flush and inside, and the lines in between are those of rounding.
  std::mt19937 random(8);
  std::uniform_real_distribution<double> u(-1.0, 1.0);
  for (const double s : kScales) {
    const assets::Mesh stair = meshOf(stairSoup(3, 0.3 * s, 0.2 * s, 1.0 * s));
    const assets::Mesh plank = meshOf(boxSoup({0.7 * s, 0.4 * s, 0.1 * s}, 2));
    const TriangleBvh stairTree(stair, 1), plankTree(plank, 1);
    for (const double off : {0.0, 1e-12, 1e-9, 1e-8, 3e-8, 1e-7, 3e-7}) {
      for (int i = 0; i < 6; ++i) {
        const double into = 0.02 + 0.01 * u(random);
        const Pose home = turned(glm::dvec3(u(random), u(random), u(random)) * s,
                                 {3.0 * u(random), 3.0 * u(random), u(random)});
        const Pose there{glm::dvec3(into - 0.05, 0.05 * u(random), 0.25 + off * u(random)) * s,
                         fromRotationVector(glm::dvec3(u(random), u(random), 0.0) * off)};
        const MeshOverlap found = overlapOf({&stairTree, home}, {&plankTree, home * there});
        EXPECT_EQ(found.meeting, Meeting::crossing);
        EXPECT_NEAR(found.depth, into * s, 2e-6 * s) << off << ' ' << i;
        for (const auto& [tree, pose] : {std::pair{&stairTree, home}, std::pair{&plankTree, home * there}}) {
          const glm::dvec3 p = transformPoint(inverse(pose), found.deepest);
          haptics::MeshPoint at;
          ASSERT_TRUE(tree->closestPoint(p, 1e300, at));
          EXPECT_TRUE(at.distance < 1e-6 * s || std::abs(windingNumber(tree->mesh(), p)) > 0.5)
              << off << ' ' << i;
        }
      }
    }
  }
}

TEST(MeshOverlap, BearsSoupOfTornAndTurnedTriangles) {
  const assets::Mesh block = rawMeshOf(shattered(boxSoup(glm::dvec3(1.0), 6), 11, 0));
  const assets::Mesh torn = rawMeshOf(shattered(boxSoup(glm::dvec3(1.0), 6), 0, 40));
  const assets::Mesh cube = boxMesh(glm::dvec3(0.4));
  const TriangleBvh treeBlock(block, 1), treeTorn(torn, 1), treeCube(cube, 1);
  for (const TriangleBvh* tree : {&treeBlock, &treeTorn}) {
    const MeshOverlap found = overlapOf({tree, {}}, {&treeCube, {{0.6, 0.03, 0.02}}});
    EXPECT_EQ(found.meeting, Meeting::crossing);
    EXPECT_FALSE(found.sheets);
    EXPECT_NEAR(found.depth, 0.1, 0.02);
    EXPECT_EQ(overlapOf({tree, {}}, {&treeCube, {{0.8, 0.03, 0.02}}}).meeting, Meeting::apart);
  }
}

}  // namespace
}  // namespace tandem::test
