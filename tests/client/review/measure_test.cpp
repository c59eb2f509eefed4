// Measures of shapes whose edges, radii, angles and distances are known.

#include "client/review/measure.h"

#include <gtest/gtest.h>

#include <cmath>

#include "assets/generate/shapes.h"
#include "assets/mesh/mesh_analysis.h"
#include "haptics/scene/contact_scene.h"
#include "tests/support/part_meshes.h"
#include "tests/support/shapes.h"

namespace tandem::test {
namespace {

using client::MeasuredPair;
using client::MeasuredPlace;

constexpr double kLength = 1e-12;  // m, what rounding in double may do at this size

/// Turned and moved, so that no axis of a part is one of the world.
const Pose kAskew{{0.3, -0.2, 0.1}, glm::normalize(glm::dquat(0.9, 0.2, -0.3, 0.1))};

MeasuredPlace placeOn(const assets::Scene& scene, const glm::dvec3& point) {
  const auto place = client::measurePlace(haptics::ContactScene(scene, 1), point);
  EXPECT_TRUE(place.has_value());
  return place.value_or(MeasuredPlace{});
}

std::vector<glm::dvec2> circle(double radius, int segments) {
  std::vector<glm::dvec2> outline;
  for (int i = 0; i < segments; ++i) {
    const double angle = 2.0 * kPi * i / segments;
    outline.emplace_back(radius * std::cos(angle), radius * std::sin(angle));
  }
  return outline;
}

assets::Mesh shaft(double radius, int segments, double height) {
  return meshOf(prismSoup(circle(radius, segments), height));
}

TEST(Measure, FindsThePlaceAndItsNearestEdgeOnATurnedBox) {
  SceneBuilder builder;
  builder.addPart(boxMesh({0.01, 0.02, 0.03}), kAskew);
  const glm::dvec3 above = transformPoint(kAskew, {0.004, 0.003, 0.02});
  const MeasuredPlace place = placeOn(builder.scene, above);
  EXPECT_EQ(place.part, 0u);
  EXPECT_NEAR(glm::distance(place.point, transformPoint(kAskew, {0.004, 0.003, 0.015})), 0.0, kLength);
  EXPECT_NEAR(glm::distance(place.normal, kAskew.orientation * glm::dvec3(0, 0, 1)), 0.0, 1e-12);
  ASSERT_TRUE(place.edge.has_value());
  EXPECT_NEAR(place.edge->length, 0.02, kLength);
  EXPECT_EQ(place.edge->segments, 1);
  EXPECT_NEAR(glm::distance(place.edge->start, place.edge->end), 0.02, kLength);
  EXPECT_FALSE(place.cylinder.has_value());
}

TEST(Measure, AnEdgeOfManySegmentsEndsAtTheCornersOfItsSheet) {
  SceneBuilder builder;
  builder.addPart(sheetMesh(0.04, 8));
  const MeasuredPlace place = placeOn(builder.scene, {0.019, 0.001, 0.0});
  ASSERT_TRUE(place.edge.has_value());
  EXPECT_EQ(place.edge->segments, 8);
  EXPECT_NEAR(place.edge->length, 0.04, kLength);
}

TEST(Measure, TheRimOfAShaftIsOneClosedEdge) {
  SceneBuilder builder;
  builder.addPart(shaft(0.01, 48, 0.05), kAskew);
  const MeasuredPlace place = placeOn(builder.scene, transformPoint(kAskew, {0.0095, 0.0, 0.06}));
  ASSERT_TRUE(place.edge.has_value());
  EXPECT_EQ(place.edge->segments, 48);
  EXPECT_EQ(place.edge->start, place.edge->end);
  EXPECT_NEAR(place.edge->length, 48 * 2.0 * 0.01 * std::sin(kPi / 48), kLength);
  EXPECT_FALSE(place.cylinder.has_value()) << "its flat end is no part of the cylinder";
}

TEST(Measure, TheSideOfAShaftHasItsDiameterAndAxis) {
  SceneBuilder builder;
  builder.addPart(shaft(0.01, 48, 0.05), kAskew);
  for (int i = 0; i < 20; ++i) {
    const double angle = 0.37 * i;
    const glm::dvec3 at(0.0101 * std::cos(angle), 0.0101 * std::sin(angle), 0.002 + 0.002 * i);
    const MeasuredPlace place = placeOn(builder.scene, transformPoint(kAskew, at));
    ASSERT_TRUE(place.cylinder.has_value()) << i;
    EXPECT_NEAR(place.cylinder->radius, 0.01, 1e-9);
    EXPECT_FALSE(place.cylinder->hollow);
    const glm::dvec3 axis = kAskew.orientation * glm::dvec3(0.0, 0.0, 1.0);
    EXPECT_NEAR(std::abs(glm::dot(place.cylinder->axis, axis)), 1.0, 1e-12);
    EXPECT_NEAR(glm::length(glm::cross(place.cylinder->middle - kAskew.position, axis)), 0.0, 1e-9);
  }
}

TEST(Measure, AChamferedCollarIsNoCylinderAcrossItsAxis) {
  generate::Solid solid;
  solid.revolve({{0.0, 0.0}, {0.020, 0.0}, {0.021, 0.001}, {0.021, 0.002}, {0.020, 0.003}, {0.0, 0.003}}, 96);
  SceneBuilder builder;
  builder.addPart(assets::analyseMesh(solid.soup(), 0.5).mesh);
  const MeasuredPlace band = placeOn(builder.scene, {0.0, 0.0015, 0.022});
  ASSERT_TRUE(band.cylinder.has_value());
  EXPECT_NEAR(band.cylinder->radius, 0.021, 1e-9);
  EXPECT_FALSE(placeOn(builder.scene, {0.0, 0.004, 0.0201}).cylinder.has_value()) << "the cone of a chamfer";
}

TEST(Measure, AnImplicitCylinderHasItsStatedDiameter) {
  SceneBuilder builder;
  assets::ImplicitShape shape;
  shape.kind = assets::ImplicitShape::Kind::cylinder;
  shape.height = 0.04;
  shape.radiusTop = shape.radiusBottom = 0.007;
  assets::Part part;
  part.name = "pin";
  part.shapes.push_back(shape);
  part.worldFromPart = kAskew;
  builder.scene.parts.push_back(part);
  const MeasuredPlace side = placeOn(builder.scene, transformPoint(kAskew, {0.006, 0.01, 0.006}));
  ASSERT_TRUE(side.cylinder.has_value());
  EXPECT_EQ(side.cylinder->radius, 0.007);
  EXPECT_FALSE(placeOn(builder.scene, transformPoint(kAskew, {0.002, 0.03, 0.0})).cylinder.has_value());
}

TEST(Measure, FacesOfABoxAreSquareOrApartByItsSize) {
  SceneBuilder builder;
  builder.addPart(boxMesh({0.01, 0.02, 0.03}), kAskew);
  const auto at = [&](double x, double y, double z) {
    return placeOn(builder.scene, transformPoint(kAskew, {x, y, z}));
  };
  const MeasuredPair square = measurePair(at(0.006, 0.001, 0.002), at(0.001, 0.011, 0.0));
  EXPECT_NEAR(square.angle, 0.5 * kPi, 1e-12);
  EXPECT_FALSE(square.across.has_value());
  const MeasuredPair opposite = measurePair(at(0.006, 0.001, 0.002), at(-0.006, 0.004, 0.0));
  EXPECT_NEAR(opposite.angle, 0.0, 1e-12);
  ASSERT_TRUE(opposite.across.has_value());
  EXPECT_NEAR(*opposite.across, 0.01, kLength);
  EXPECT_NEAR(opposite.distance, std::sqrt(0.01 * 0.01 + 0.003 * 0.003 + 0.002 * 0.002), kLength);
}

TEST(Measure, TheAngleOfTwoWallsIsThatOfTheGroove) {
  for (const double half : {0.02, 0.3, 0.7}) {
    SceneBuilder builder;
    builder.addPart(grooveMesh(0.05, half), kAskew);
    const auto at = [&](double x) {
      return placeOn(builder.scene, transformPoint(kAskew, {x * std::sin(half), 0.0, 0.02 * std::cos(half)}));
    };
    EXPECT_NEAR(measurePair(at(0.02), at(-0.02)).angle, 2.0 * half, 1e-12) << half;
  }
}

TEST(Measure, AxesOfTwoShaftsAreApartHoweverTheyAreTouched) {
  SceneBuilder builder;
  const std::uint32_t mesh = builder.addMesh(shaft(0.01, 64, 0.05));
  builder.addPart(mesh, kAskew);
  builder.addPart(mesh, kAskew * Pose{{0.05, 0.03, 0.2}, glm::dquat(1, 0, 0, 0)});
  const MeasuredPlace a = placeOn(builder.scene, transformPoint(kAskew, {-0.01, 0.001, 0.02}));
  const MeasuredPlace b = placeOn(builder.scene, transformPoint(kAskew, {0.05, 0.041, 0.22}));
  ASSERT_TRUE(a.cylinder && b.cylinder);
  const MeasuredPair pair = measurePair(a, b);
  ASSERT_TRUE(pair.across.has_value());
  EXPECT_NEAR(*pair.across, std::hypot(0.05, 0.03), 1e-9);
}

TEST(Measure, FollowsPartsToWhereTheyAreNow) {
  SceneBuilder builder;
  builder.addPart(boxMesh(glm::dvec3(0.01)));
  builder.addPart(boxMesh(glm::dvec3(0.01)), Pose{{0.05, 0.0, 0.0}, glm::dquat(1, 0, 0, 0)});
  const haptics::ContactScene contact(builder.scene, 1);
  const std::vector<Pose> swapped{builder.scene.parts[1].worldFromPart, builder.scene.parts[0].worldFromPart};
  const auto place = client::measurePlace(contact, {0.05, 0.0, 0.0055}, swapped);
  ASSERT_TRUE(place.has_value());
  EXPECT_EQ(place->part, 0u);
}

}  // namespace
}  // namespace tandem::test
