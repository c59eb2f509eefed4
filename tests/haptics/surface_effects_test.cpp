#include "haptics/surface_effects.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/haptics/hand_probe.h"

namespace tandem::test {
namespace {

using assets::Surface;

/// A sheet in z = 0 of one surface.
assets::Scene sheetOf(const Surface& surface, double scale = 1.0) {
  SceneBuilder b;
  b.scene.surfaces.push_back(surface);
  b.scene.materials[0].surface = 0;
  b.addPart(sheetMesh(0.2 * scale, 4));
  return b.scene;
}

TEST(SurfaceEffects, ViscosityDragsAgainstTheMotion) {
  Surface surface;
  surface.viscosity = 5.0;
  HandProbe hand(sheetOf(surface), springOnly(1000.0));
  hand.at({-0.05, 0.0012, 0.005});
  hand.to({-0.05, 0.0012, -0.002}, 1e-4);
  for (int i = 1; i < 100; ++i) hand.at({-0.05 + 1e-4 * i, 0.0012, -0.002});  // 0.1 m/s
  EXPECT_NEAR(hand.out.toHand.force.x, -5.0 * 0.1, 1e-9);
  EXPECT_NEAR(hand.out.toHand.force.y, 0.0, 1e-9);
  EXPECT_NEAR(hand.out.toHand.force.z, 2.0, 1e-6);
  hand.to({-0.05, 0.0012, 0.005}, 1e-3);
  EXPECT_EQ(hand.out.toHand.force, glm::dvec3(0.0));
}

TEST(SurfaceEffects, ViscosityNeverPullsTheToolIn) {
  Surface surface;
  surface.viscosity = 50.0;
  HandProbe hand(sheetOf(surface), springOnly(1000.0));
  hand.at({0.0, 0.0012, 0.005});
  hand.to({0.0, 0.0012, -0.002}, 1e-4);
  for (int i = 1; i < 40; ++i) {
    hand.at({0.0, 0.0012, -0.002 + 5e-4 * i});  // 0.5 m/s out: 25 N of drag against 2 N
    EXPECT_GE(hand.out.toHand.force.z, -1e-12);
  }
}

TEST(SurfaceEffects, ViscosityGivesNothingToAToolThatBuzzes) {
  // Velocity that turns round every tick: drag held for the next tick would push along the motion.
  Surface surface;
  surface.viscosity = 5.0;
  HandProbe hand(sheetOf(surface), springOnly(1000.0));
  hand.at({0.0, 0.0012, 0.005});
  hand.to({0.0, 0.0012, -0.002}, 1e-4);
  double given = 0.0, naive = 0.0;
  double last = 0.0;
  for (int i = 1; i < 200; ++i) {
    const double x = (i % 2) * 1e-5, step = x - last;
    given += hand.out.toHand.force.x * step;
    naive += -5.0 * hand.sample.twist.linear.x * step;
    hand.at({x, 0.0012, -0.002});
    last = x;
  }
  EXPECT_LE(given, 5.0 * 0.01 * 1e-5 * 1.001) << "more than the first tick, which has no history";
  EXPECT_GT(naive, 100.0 * 5.0 * 0.01 * 1e-5) << "plain drag at one tick's delay would have fed the buzz";
}

}  // namespace
}  // namespace tandem::test
