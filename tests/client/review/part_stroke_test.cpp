#include "client/review/part_stroke.h"

#include <gtest/gtest.h>

#include "tests/support/shapes.h"

namespace tandem::client {
namespace {

PartStroke strokeOf(const assets::Scene& scene) {
  const haptics::ContactScene contact(scene);
  const haptics::ContactWorld world(contact);
  haptics::TickState state(contact);
  return strokePart(contact, world, state, 0);
}

TEST(PartStroke, TouchesAsAHandDoesWithoutAJump) {
  for (const double scale : {1e-3, 1.0, 20.0}) {
    test::SceneBuilder b;
    b.addPart(test::boxMesh(glm::dvec3(0.1, 0.2, 0.05) * scale));
    const PartStroke stroke = strokeOf(b.scene);
    EXPECT_EQ(stroke.tick_us.size(), 8u * 60u);
    EXPECT_GT(stroke.touching, stroke.tick_us.size() * 8 / 10) << scale;
    const double size = glm::length(glm::dvec3(0.1, 0.2, 0.05)) * scale;
    EXPECT_LE(stroke.longestStep, 1.5001e-3 * size) << scale;
    EXPECT_GT(stroke.error, 0.0) << "the tool rests a skin above the surface";
    EXPECT_LT(stroke.error, 1e-8 * size) << scale;
  }
}

TEST(PartStroke, CountsWhatTheFacetsOfARoundShapeAreUnderIt) {
  test::SceneBuilder b;
  b.addPart(test::boxMesh(glm::dvec3(0.1)));
  b.scene.parts[0].shapes.resize(1);
  b.scene.parts[0].shapes[0].kind = assets::ImplicitShape::Kind::sphere;
  b.scene.parts[0].shapes[0].radiusBottom = 0.05;
  const PartStroke stroke = strokeOf(b.scene);
  EXPECT_GT(stroke.touching, stroke.tick_us.size() * 8 / 10);
  EXPECT_NEAR(stroke.error, 5e-6, 1e-8);
}

TEST(PartStroke, APartWithoutGeometryIsNotStroked) {
  test::SceneBuilder b;
  b.addPart(test::boxMesh(glm::dvec3(0.1)));
  b.scene.parts[0].mesh = assets::kNone;
  b.addPart(test::boxMesh(glm::dvec3(0.1)));
  EXPECT_TRUE(strokeOf(b.scene).tick_us.empty());
}

}  // namespace
}  // namespace tandem::client
