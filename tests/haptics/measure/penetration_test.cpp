#include "haptics/measure/penetration.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include <glm/geometric.hpp>

#include "tests/support/part_meshes.h"
#include "tests/support/winding_number.h"

namespace tandem::test {
namespace {

using haptics::deepestPenetration;
using haptics::DepthModel;
using haptics::PenetrationDepth;
using haptics::PenetrationMeter;

constexpr double kPi = std::numbers::pi;

Pose at(double x, double y, double z, const glm::dvec3& rotation = glm::dvec3(0.0)) {
  return {{x, y, z}, fromRotationVector(rotation)};
}

double depthOf(const assets::Mesh& a, const Pose& poseA, const assets::Mesh& b, const Pose& poseB = {}) {
  const double there = deepestPenetration(DepthModel(a), poseA, DepthModel(b), poseB).depth;
  EXPECT_NEAR(deepestPenetration(DepthModel(b), poseB, DepthModel(a), poseA).depth, there, 1e-8);
  return there;
}

/// The same two things somewhere else in the world.
const Pose kElsewhere = at(0.3, -0.2, 0.7, {0.4, -1.1, 0.6});

TEST(DepthModel, KeepsOnlyWhatIsNotFlatOrStraight) {
  const DepthModel box(meshOf(boxSoup({0.01, 0.02, 0.03}, 8)));
  EXPECT_EQ(box.facetCount(), 6u);
  EXPECT_EQ(box.ridges().size(), 12u);
  EXPECT_EQ(box.corners().size(), 8u);
  const DepthModel peg(meshOf(pegSoup({0.01, 0.04, 0.001, {96, 20}})));
  EXPECT_EQ(peg.ridges().size(), 96u * 5u);  // three rims, the chamfer's and the wall's lines
  EXPECT_LE(peg.facetCount(), 96u * 2u + 2u * 96u);
  // Lines of a bore are concave: only its rims can be the deepest.
  const DepthModel bore(meshOf(boredBlockSoup({0.01, 0.045, 0.06, 0.045, 0.0, Fit::around, {96, 20}})));
  EXPECT_EQ(bore.ridges().size(), 96u * 2u + 12u);
}

TEST(Penetration, OfABoxInABlockIsItsDepth) {
  const assets::Mesh box = meshOf(boxSoup({0.01, 0.01, 0.01}, 3));
  const assets::Mesh block = meshOf(boxSoup({0.06, 0.06, 0.06}, 5));
  for (const double depth : {1e-3, 1e-5, 1e-7}) {
    for (const double rotation : {0.0, 0.3, kPi / 4}) {
      const Pose pose = at(0.003, -0.001, 0.035 - depth, {0.0, 0.0, rotation});
      EXPECT_NEAR(depthOf(box, pose, block), depth, 1e-9);
      EXPECT_NEAR(depthOf(box, kElsewhere * pose, block, kElsewhere), depth, 1e-8);
    }
  }
  // A corner first: the lowest point is the corner.
  const Pose onCorner =
      at(0.002, 0.001, 0.03 + 0.005 * std::sqrt(3.0) - 5e-4,
         {std::atan(std::sqrt(2.0)) / std::sqrt(2.0), -std::atan(std::sqrt(2.0)) / std::sqrt(2.0), 0.0});
  EXPECT_NEAR(depthOf(box, onCorner, block), 5e-4, 1e-8);
}

TEST(Penetration, PointsTheWayOut) {
  const DepthModel box(meshOf(boxSoup({0.01, 0.01, 0.01}))), block(meshOf(boxSoup({0.06, 0.06, 0.06})));
  const PenetrationDepth found = deepestPenetration(box, at(0, 0, 0.035 - 1e-4), block, {});
  EXPECT_TRUE(found.ofA);
  EXPECT_NEAR(found.normal.z, 1.0, 1e-9);
  EXPECT_NEAR(found.point.z, 0.03 - 1e-4, 1e-12);
  const PenetrationDepth swapped = deepestPenetration(block, {}, box, at(0, 0, 0.035 - 1e-4));
  EXPECT_NEAR(swapped.normal.z, -1.0, 1e-9);
}

TEST(Penetration, IsZeroApartAndTouching) {
  const assets::Mesh box = meshOf(boxSoup({0.01, 0.01, 0.01}, 4));
  const assets::Mesh block = meshOf(boxSoup({0.06, 0.06, 0.06}, 7));
  EXPECT_EQ(depthOf(box, at(0.0, 0.0, 0.2), block), 0.0);
  EXPECT_EQ(depthOf(box, at(0.0, 0.0, 0.0351), block), 0.0);
  // Faces in one plane, also with edges in one line and corners on corners.
  for (const glm::dvec2& offset :
       {glm::dvec2(0.0), glm::dvec2(0.025), glm::dvec2(0.0123, 0.025), glm::dvec2(0.03, 0.0)}) {
    for (const double rotation : {0.0, 0.2}) {
      const Pose pose = at(offset.x, offset.y, 0.035, {0.0, 0.0, rotation});
      EXPECT_LE(depthOf(box, pose, block), 1e-9 * 0.06) << offset.x << ' ' << rotation;
      EXPECT_LE(depthOf(box, kElsewhere * pose, block, kElsewhere), 1e-9 * 0.06)
          << offset.x << ' ' << rotation;
    }
  }
  // Side by side, of the same size.
  EXPECT_LE(depthOf(box, at(0.01, 0.0, 0.0), box), 1e-11);
}

TEST(Penetration, OfABallIsThatOfItsLowestPoint) {
  const assets::Mesh ball = meshOf(ballSoup(0.01, {48, 24})), block = meshOf(boxSoup({0.06, 0.06, 0.06}, 6));
  EXPECT_NEAR(depthOf(ball, at(0.003, 0.001, 0.04 - 2e-4), block), 2e-4, 1e-9);
  EXPECT_NEAR(depthOf(ball, at(0.003, 0.001, 0.04 + 1e-6), block), 0.0, 0.0);
  // Two balls, pole on pole: the poles lie in each other by as much.
  EXPECT_NEAR(depthOf(ball, at(0.0, 0.0, 0.02 - 2e-4), ball), 2e-4, 2e-6);
}

TEST(Penetration, OfAPegThroughTheWallOfABoreIsExact) {
  const double clearance = 10e-6;
  for (const int rings : {1, 30}) {
    const assets::Mesh peg = meshOf(pegSoup({0.01, 0.04, 0.001, {96, rings}}));
    const assets::Mesh bore =
        meshOf(boredBlockSoup({0.01 + clearance, 0.045, 0.06, 0.045, 0.0, Fit::around, {96, rings}}));
    for (const double depth : {-2e-6, 1e-6, 50e-6}) {
      // A corner of the peg meets the middle of a side.
      const Pose pose = at((clearance + depth) * std::cos(kPi / 96), (clearance + depth) * std::sin(kPi / 96),
                           -0.03, {0.0, 0.0, kPi / 96});
      EXPECT_NEAR(depthOf(peg, pose, bore), std::max(0.0, depth), 2e-9) << depth;
    }
  }
}

TEST(Penetration, OfTwoCrossedEdgesIsBetweenTheirFaces) {
  // Two beams on their edges: the lower edge of one is `depth` below the upper edge of the other.
  const assets::Mesh beam = meshOf(boxSoup({0.1, 0.01, 0.01}, 2));
  const double half = 0.01 / std::sqrt(2.0);
  for (const double depth : {1e-3, 1e-5}) {
    const Pose upper = at(0.0, 0.0, 2.0 * half - depth, {kPi / 4, 0.0, 0.0});
    Pose lower = at(0.0, 0.0, 0.0, {0.0, 0.0, kPi / 2});
    lower.orientation = lower.orientation * fromRotationVector({kPi / 4, 0.0, 0.0});
    EXPECT_NEAR(depthOf(beam, upper, beam, lower), depth / std::sqrt(2.0), 2e-8) << depth;
  }
}

TEST(Penetration, OfWhatIsWhollyInsideIsTheWayToTheSurface) {
  const assets::Mesh cube = meshOf(boxSoup({0.005, 0.005, 0.005}, 2)),
                     block = meshOf(boxSoup({0.06, 0.06, 0.06}, 3));
  EXPECT_NEAR(depthOf(cube, at(0.0, 0.0, 0.0), block), 0.0275, 1e-8);
  EXPECT_NEAR(depthOf(cube, at(0.01, 0.001, -0.002), block), 0.0225, 1e-8);
  // In a hollow it is not inside.
  const assets::Mesh hollow =
      meshOf(joined(boxSoup({0.06, 0.06, 0.06}), insideOut(boxSoup({0.02, 0.02, 0.02}))));
  EXPECT_EQ(depthOf(cube, at(0.001, 0.0, 0.0), hollow), 0.0);
}

TEST(Penetration, OfThinPlatesIsAtMostHalfTheirThickness) {
  const assets::Mesh plate = meshOf(boxSoup({0.04, 0.04, 0.0005}, 4));
  EXPECT_NEAR(depthOf(plate, at(0.01, 0.005, 0.0005 - 1e-4), plate), 1e-4, 1e-9);
  EXPECT_NEAR(depthOf(plate, at(0.01, 0.005, 0.0005 - 1e-4, {0.0, 0.0, 0.7}), plate), 1e-4, 1e-9);
  // Crossed like two cards in slots: an edge runs through the middle of the other.
  EXPECT_NEAR(depthOf(plate, at(0.0, 0.0, 0.01, {kPi / 2, 0.0, 0.0}), plate), 0.00025, 1e-8);
}

TEST(Penetration, SeesWhatGoesThroughTheMiddleOfAFace) {
  const assets::Mesh ball = meshOf(ballSoup(0.01, {48, 24})),
                     plate = meshOf(boxSoup({0.06, 0.06, 0.0005}, 1));
  const double found = depthOf(ball, at(0.002, 0.003, 0.0), plate);
  EXPECT_LT(found, 0.00975);
  EXPECT_GT(found, 0.00975 - 2.0 * chordSag(0.01, 48));
}

TEST(Penetration, OfAnOpenSurfaceCountsWhatCrossesIt) {
  assets::TriangleSoup sheet;
  sheet.positions = {{-0.03, -0.03, 0.0}, {0.03, -0.03, 0.0}, {0.03, 0.03, 0.0}, {-0.03, 0.03, 0.0}};
  sheet.triangles = {{0, 1, 2}, {0, 2, 3}};
  sheet.triangleMaterial = {0, 0};
  const DepthModel open(meshOf(sheet)), box(meshOf(boxSoup({0.01, 0.01, 0.01}, 2)));
  EXPECT_FALSE(open.solid());
  for (const double side : {1.0, -1.0}) {
    EXPECT_NEAR(deepestPenetration(box, at(0.003, 0.001, side * (0.005 - 3e-4)), open, {}).depth, 3e-4, 1e-8);
  }
  EXPECT_EQ(deepestPenetration(box, at(0.003, 0.001, 0.0051), open, {}).depth, 0.0);
  // A torn solid: the same.
  const DepthModel torn(meshOf(shattered(boxSoup({0.06, 0.06, 0.06}, 6), 0, 50)));
  EXPECT_FALSE(torn.solid());
  EXPECT_NEAR(deepestPenetration(box, at(0.0031, 0.0012, 0.035 - 3e-4), torn, {}).depth, 3e-4, 1e-8);
}

TEST(Penetration, TakesMeshesAsTheyAre) {
  const assets::Mesh box = rawMeshOf(boxSoup({0.01, 0.01, 0.01}, 3)),
                     block = rawMeshOf(boxSoup({0.06, 0.06, 0.06}, 5));
  EXPECT_NEAR(depthOf(box, at(0.0, 0.0, 0.035 - 1e-4), block), 1e-4, 1e-9);
  EXPECT_NEAR(depthOf(meshOf(insideOut(boxSoup({0.01, 0.01, 0.01}))), at(0.0, 0.0, 0.035 - 1e-4), block),
              1e-4, 1e-9);
  EXPECT_EQ(depthOf(assets::Mesh(), {}, block), 0.0);
}

/// The largest distance among many points of a's surface that lie in b, by brute force over all triangles.
double sampledDepth(const assets::Mesh& a, const Pose& bFromA, const assets::Mesh& b, int samples) {
  double deepest = 0.0;
  for (const auto& t : a.triangles) {
    for (int i = 0; i <= samples; ++i) {
      for (int j = 0; i + j <= samples; ++j) {
        const double u = 1.0 * i / samples, v = 1.0 * j / samples;
        const glm::dvec3 p = transformPoint(
            bFromA, a.positions[t[0]] * (1.0 - u - v) + a.positions[t[1]] * u + a.positions[t[2]] * v);
        double least = 1e300;
        for (const auto& s : b.triangles) {
          const glm::dvec3 q =
              haptics::closestPointOnTriangle(p, {b.positions[s[0]], b.positions[s[1]], b.positions[s[2]]})
                  .point;
          least = std::min(least, glm::length(p - q));
          if (least <= deepest) break;
        }
        if (least > deepest && windingNumber(b, p) > 0.5) deepest = least;
      }
    }
  }
  return deepest;
}

TEST(Penetration, AgreesWithManyPointsInAnyPose) {
  const assets::Mesh meshes[] = {meshOf(boxSoup({0.02, 0.01, 0.015})),
                                 meshOf(pegSoup({0.006, 0.02, 0.002, {16, 1}})),
                                 meshOf(stairSoup(3, 0.006, 0.004, 0.02)), meshOf(ballSoup(0.008, {16, 6}))};
  std::mt19937 random(7);
  std::uniform_real_distribution<double> share(-1.0, 1.0);
  const auto vector = [&](double size) {
    return size * glm::dvec3{share(random), share(random), share(random)};
  };
  int deep = 0;
  for (int trial = 0; trial < 16; ++trial) {
    const assets::Mesh &a = meshes[random() % 4], &b = meshes[random() % 4];
    const Pose pose{vector(0.016), fromRotationVector(vector(1.8))};
    const double found = deepestPenetration(DepthModel(a), pose, DepthModel(b), {}).depth;
    const double swapped = deepestPenetration(DepthModel(b), {}, DepthModel(a), pose).depth;
    EXPECT_NEAR(swapped, found, 0.01 * found) << trial;
    const double sampled = std::max(sampledDepth(a, pose, b, 8), sampledDepth(b, inverse(pose), a, 8));
    EXPECT_GE(found, 0.99 * sampled) << trial;    // deep: faces are searched to 1 %
    EXPECT_LE(found, sampled + 1.8e-3) << trial;  // half the distance of samples
    if (found > 1e-3) ++deep;
  }
  EXPECT_GT(deep, 4);
}

TEST(Penetration, IsTheSameHoweverItIsFollowed) {
  const auto peg = std::make_shared<DepthModel>(meshOf(pegSoup({0.01, 0.04, 0.001, {96, 10}})));
  const auto bore = std::make_shared<DepthModel>(
      meshOf(boredBlockSoup({0.01001, 0.045, 0.06, 0.045, 0.001, Fit::around, {96, 10}})));
  PenetrationMeter meter(peg, bore);
  for (int i = 0; i < 40; ++i) {
    const double s = 5e-3 * i;
    const Pose pose = at(3e-5 * std::sin(80.0 * s), 3e-5 * std::cos(60.0 * s), 0.004 - 0.2 * s,
                         {2e-4 * std::sin(50.0 * s), 3e-4 * std::cos(30.0 * s), 0.4 * s});
    EXPECT_NEAR(meter.measure(pose, {}).depth, deepestPenetration(*peg, pose, *bore, {}).depth, 2e-8) << i;
  }
}

}  // namespace
}  // namespace tandem::test
