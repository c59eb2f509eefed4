// Edges and corners of a box, and how far a ball rolls about them.

#include "haptics/proxy/crease.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include <glm/geometric.hpp>

#include "tests/support/shapes.h"

namespace tandem::test {
namespace {

using haptics::Crease;
using haptics::RollLimit;
using haptics::SurfacePoint;

constexpr double kHalf = 0.05;                       // m, of the box
constexpr double kQuarter = 0.5 * std::numbers::pi;  // rad
constexpr double kSkin = 1e-9;                       // m
const double kDiagonal = std::numbers::sqrt2 * 0.5;

/// A box of 0.1 m in a world that is turned and shifted, so that frames cannot be mixed up.
class CreaseOfABox : public testing::Test {
 protected:
  static assets::Scene scene() {
    SceneBuilder b;
    b.addPart(boxMesh(glm::dvec3(2.0 * kHalf)), {{0.3, -0.2, 0.1}, fromRotationVector({0.4, -0.3, 0.7})});
    return b.scene;
  }
  SurfacePoint under(const glm::dvec3& p) const {  // p in the part's frame
    SurfacePoint found;
    EXPECT_TRUE(world_.nearest(0, out(p), 1.0, found));
    return found;
  }
  glm::dvec3 out(const glm::dvec3& p) const { return transformPoint(world_.pose(0), p); }
  glm::dvec3 turned(const glm::dvec3& v) const { return transformVector(world_.pose(0), v); }

  assets::Scene scene_ = scene();
  haptics::ContactScene contact_{scene_, 1};
  haptics::ContactWorld world_{contact_};
};

TEST_F(CreaseOfABox, UnderAnEdgeItIsThatEdge) {
  const Crease crease = creaseUnder(world_, under({kHalf + 0.01, 0.013, kHalf + 0.01}), kSkin);
  const glm::dvec3 along = crease.b - crease.a;
  EXPECT_NEAR(glm::length(along), 2.0 * kHalf, 1e-12);
  EXPECT_NEAR(std::abs(glm::dot(along, turned({0.0, 1.0, 0.0}))), 2.0 * kHalf, 1e-12);
  EXPECT_NEAR(glm::length(0.5 * (crease.a + crease.b) - out({kHalf, 0.0, kHalf})), 0.0, 1e-12);
}

TEST_F(CreaseOfABox, UnderACornerItIsThatCorner) {
  const Crease crease = creaseUnder(world_, under(glm::dvec3(kHalf + 0.01)), kSkin);
  EXPECT_EQ(crease.a, crease.b);
  EXPECT_NEAR(glm::length(crease.a - out(glm::dvec3(kHalf))), 0.0, 1e-12);
}

TEST_F(CreaseOfABox, WayOverItLeavesOutWhatLeadsAlong) {
  const Crease edge{{1.0, 1.0, 0.0}, {1.0, 3.0, 0.0}}, corner{glm::dvec3(1.0), glm::dvec3(1.0)};
  EXPECT_DOUBLE_EQ(lengthAcross(edge, {0.0, 7.0, 0.0}), 0.0);
  EXPECT_DOUBLE_EQ(lengthAcross(edge, {0.003, 7.0, -0.004}), 0.005);
  EXPECT_DOUBLE_EQ(lengthAcross(corner, {0.003, 0.0, -0.004}), 0.005);
}

/// Over the edge between +x and +z.
TEST_F(CreaseOfABox, ABallOnAnEdgeRollsToTheFaceAheadAndNoFurther) {
  for (const double tilt : {0.1, 0.3, 1.2}) {  // rad, of the normal from +z towards +x
    const glm::dvec3 normal(std::sin(tilt), 0.0, std::cos(tilt)), tangent(normal.z, 0.0, -normal.x);
    SurfacePoint contact = under({kHalf + 0.01, 0.013, kHalf + 0.01});
    contact.normal = turned(normal);
    const RollLimit over = rollLimit(world_, contact, kSkin, turned(tangent));
    EXPECT_NEAR(over.angle, kQuarter - tilt, 1e-9);
    ASSERT_NE(over.triangle, haptics::kNoTriangle);
    for (const glm::dvec3& p : {world_.surfaceAt(0, over.triangle, contact.point).point})
      EXPECT_NEAR(glm::length(p - contact.point), 0.0, 1e-9);  // it meets the edge
    const RollLimit back = rollLimit(world_, contact, kSkin, turned(-tangent));
    EXPECT_NEAR(back.angle, tilt, 1e-9);
  }
}

TEST_F(CreaseOfABox, ABallOnACornerRollsToTheEdgeAhead) {
  SurfacePoint contact = under(glm::dvec3(kHalf + 0.01));
  contact.normal = turned({0.0, 0.0, 1.0});
  // Straight outwards over the corner, away from all three faces: to the plane of the other edge and no less.
  const RollLimit out = rollLimit(world_, contact, kSkin, turned({kDiagonal, kDiagonal, 0.0}));
  EXPECT_GE(out.angle, kQuarter - 1e-9);
  // Towards the middle of the face the ball already lies on what is ahead.
  const RollLimit in = rollLimit(world_, contact, kSkin, turned({-kDiagonal, -kDiagonal, 0.0}));
  EXPECT_NEAR(in.angle, 0.0, 1e-9);
}

TEST_F(CreaseOfABox, OnTheDiagonalOfAFlatFaceThereIsNothingToRollAbout) {
  const SurfacePoint contact = under({0.0, 0.0, kHalf + 0.01});  // the diagonal of the face runs through
  for (const double angle : {0.2, 1.1, 2.5, 4.0}) {
    const glm::dvec3 tangent(std::cos(angle), std::sin(angle), 0.0);
    EXPECT_NEAR(rollLimit(world_, contact, kSkin, turned(tangent)).angle, 0.0, 1e-9);
  }
}

}  // namespace
}  // namespace tandem::test
