#include "haptics/surface/surface_effects.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "haptics/surface/apply_surface.h"
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
  EXPECT_NEAR(hand.out.hands[0].toHand.force.x, -5.0 * 0.1, 1e-9);
  EXPECT_NEAR(hand.out.hands[0].toHand.force.y, 0.0, 1e-9);
  EXPECT_NEAR(hand.out.hands[0].toHand.force.z, 2.0, 1e-6);
  hand.to({-0.05, 0.0012, 0.005}, 1e-3);
  EXPECT_EQ(hand.out.hands[0].toHand.force, glm::dvec3(0.0));
}

TEST(SurfaceEffects, ViscosityNeverPullsTheToolIn) {
  Surface surface;
  surface.viscosity = 50.0;
  HandProbe hand(sheetOf(surface), springOnly(1000.0));
  hand.at({0.0, 0.0012, 0.005});
  hand.to({0.0, 0.0012, -0.002}, 1e-4);
  for (int i = 1; i < 40; ++i) {
    hand.at({0.0, 0.0012, -0.002 + 5e-4 * i});  // 0.5 m/s out: 25 N of drag against 2 N
    EXPECT_GE(hand.out.hands[0].toHand.force.z, -1e-12);
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
    given += hand.out.hands[0].toHand.force.x * step;
    naive += -5.0 * hand.sample.twist.linear.x * step;
    hand.at({x, 0.0012, -0.002});
    last = x;
  }
  EXPECT_LE(given, 5.0 * 0.01 * 1e-5 * 1.001) << "more than the first tick, which has no history";
  EXPECT_GT(naive, 100.0 * 5.0 * 0.01 * 1e-5) << "plain drag at one tick's delay would have fed the buzz";
}

TEST(SurfaceEffects, VibrationStaysWithinItsAmplitudeAndStopsInFreeAir) {
  Surface surface;
  surface.vibrationFrequency = 50.0;
  surface.vibrationAmplitude = 0.4;
  HandProbe hand(sheetOf(surface), springOnly(1000.0));
  hand.at({0.0, 0.0012, 0.005});
  hand.to({0.0, 0.0012, -0.002}, 1e-4);
  double low = 1e9, high = -1e9;
  for (int i = 0; i < 200; ++i) {
    const double f = hand.at({0.0, 0.0012, -0.002}).hands[0].toHand.force.z - 2.0;
    low = std::min(low, f), high = std::max(high, f);
  }
  EXPECT_NEAR(high, 0.4, 1e-3);
  EXPECT_NEAR(low, -0.4, 1e-3);
  hand.to({0.0, 0.0012, -0.0001}, 1e-4);
  for (int i = 0; i < 50; ++i) EXPECT_GE(hand.at({0.0, 0.0012, -0.0001}).hands[0].toHand.force.z, 0.0);
  hand.to({0.0, 0.0012, 0.005}, 1e-3);
  EXPECT_EQ(hand.out.hands[0].toHand.force, glm::dvec3(0.0));
}

TEST(SurfaceEffects, StickSlipHoldsThenLetsGo) {
  Surface surface;
  surface.stickSlipForce = 0.5;
  surface.stickSlipStiffness = 500.0;
  HandProbe hand(sheetOf(surface), springOnly(1000.0));
  hand.at({0.0, 0.0012, 0.005});
  hand.to({0.0, 0.0012, -0.002}, 1e-4);
  double strongest = 0.0;
  int slips = 0;
  for (int i = 1; i <= 1000; ++i) {  // 10 mm: every 1 mm a slip
    const double before = hand.out.hands[0].toHand.force.x;
    const double now = hand.at({1e-5 * i, 0.0012, -0.002}).hands[0].toHand.force.x;
    strongest = std::max(strongest, std::abs(now));
    slips += now > before + 0.3 ? 1 : 0;
  }
  EXPECT_LE(strongest, 0.5 + 1e-9);
  EXPECT_GT(strongest, 0.49);
  EXPECT_NEAR(slips, 10, 1);
}

TEST(SurfaceEffects, MagnetPullsWithoutGainingEnergyAtEveryScale) {
  for (const double scale : {1e-3, 1.0, 20.0}) {
    Surface surface;
    surface.magneticForce = 0.8;
    surface.magneticDistance = 0.01 * scale;
    HandProbe hand(sheetOf(surface, scale), springOnly(1000.0 / scale));
    double strongest = 0.0, work = 0.0, before = 0.0;
    for (int i = 0; i <= 2000; ++i) {
      const double z = (0.006 + 0.008 * std::cos(2.0 * kPi * i / 2000.0)) * scale;
      const double f = hand.at({0.0, 0.0012 * scale, z}).hands[0].toHand.force.z;
      if (z > 0.0) strongest = std::min(strongest, f);
      EXPECT_TRUE(z <= 0.0101 * scale || f == 0.0);
      if (i > 0) {
        const double last = (0.006 + 0.008 * std::cos(2.0 * kPi * (i - 1) / 2000.0)) * scale;
        work += 0.5 * (f + before) * (z - last);
      }
      before = f;
    }
    EXPECT_NEAR(strongest, -0.8, 1e-4) << scale;
    EXPECT_NEAR(work, 0.0, 1e-5 * scale) << scale;
  }
}

TEST(SurfaceEffects, PopsThroughBeyondTheForceAndIsFeltAgainFromTheOtherSide) {
  Surface surface;
  surface.popThroughForce = 2.0;
  HandProbe hand(sheetOf(surface), springOnly(1000.0));
  hand.at({0.0, 0.0012, 0.005});
  hand.to({0.0, 0.0012, -0.0019}, 1e-4);
  EXPECT_NEAR(hand.out.hands[0].toHand.force.z, 1.9, 1e-6);
  hand.at({0.0, 0.0012, -0.0021});
  EXPECT_NE(hand.out.flags & haptics::kFlagPopThrough, 0u);
  EXPECT_LT(glm::length(hand.out.hands[0].toHand.force), 1e-6);
  hand.to({0.0, 0.0012, -0.005}, 1e-3);
  EXPECT_EQ(hand.out.hands[0].toHand.force, glm::dvec3(0.0));
  hand.to({0.0, 0.0012, 0.001}, 1e-4);
  EXPECT_NEAR(hand.out.hands[0].toHand.force.z, -1.0, 1e-6);
}

TEST(SurfaceEffects, ReliefIsThePotentialOfItsForce) {
  Surface surface;
  surface.texture.pattern = assets::SurfaceTexture::Pattern::sine;
  surface.texture.amplitude = 0.0002;
  surface.texture.wavelength = 0.004;
  HandProbe hand(sheetOf(surface), springOnly(1000.0));
  hand.at({-0.01, 0.0012, 0.005});
  hand.to({-0.01, 0.0012, -0.001}, 1e-4);
  for (int i = 1; i < 400; ++i) {
    const double x = -0.01 + 5e-5 * i, turn = 2.0 * kPi * x / 0.004;
    const double depth = 0.001 + 0.0002 * std::sin(turn);
    hand.at({x, 0.0012, -0.001});
    EXPECT_NEAR(hand.out.hands[0].toHand.force.z, 1000.0 * depth, 1e-6);
    EXPECT_NEAR(hand.out.hands[0].toHand.force.x,
                -1000.0 * depth * 0.0002 * std::cos(turn) * 2.0 * kPi / 0.004, 1e-6);
  }
}

TEST(SurfaceEffects, AMaterialThatAsksForNothingMakesNoSurfaceScene) {
  SceneBuilder b;
  b.scene.materials[0].stiffness = 700.0;
  b.scene.materials[0].staticFriction = 0.4;
  b.addPart(sheetMesh(0.2, 4));
  EXPECT_EQ(haptics::ContactWorld(haptics::ContactScene(b.scene, 1)).surfaces(), nullptr);
  b.scene.surfaces.emplace_back().viscosity = 1.0;
  EXPECT_EQ(haptics::ContactWorld(haptics::ContactScene(b.scene, 1)).surfaces(), nullptr) << "nobody uses it";
  b.scene.materials[0].surface = 0;
  EXPECT_NE(haptics::ContactWorld(haptics::ContactScene(b.scene, 1)).surfaces(), nullptr);
}

TEST(SurfaceEffects, OfManyMagnetsTheNearestPull) {
  // A row of balls, 5 mm apart; each pulls within 2 mm. The tool flies along above them.
  SceneBuilder b;
  b.scene.surfaces.emplace_back();
  b.scene.surfaces[0].magneticForce = 0.5;
  b.scene.surfaces[0].magneticDistance = 0.002;
  b.scene.materials[0].surface = 0;
  const std::uint32_t ball = b.addMesh(sphereMesh(0.002, 24));
  for (int i = 0; i < 300; ++i) b.addPart(ball, {{0.005 * i, 0.0, 0.0}, {1.0, 0.0, 0.0, 0.0}});
  HandProbe hand(b.scene, springOnly(1000.0));
  for (const int i : {3, 120, 299, 0}) {
    hand.to({0.005 * i, 0.0, 0.02}, 0.01);
    const haptics::TickOutput& out = hand.at({0.005 * i, 0.0, 0.003});
    EXPECT_NEAR(out.hands[0].toHand.force.z, -0.5, 1e-6) << i;  // half way up its reach
    EXPECT_EQ(out.flags & haptics::kFlagOverflow, 0u);
  }
}

TEST(SurfaceEffects, AMagnetGivesNoEnergyAroundItsEdgesAndCorners) {
  for (const double scale : {1e-3, 1.0, 20.0}) {
    SceneBuilder b;
    b.scene.surfaces.emplace_back();
    b.scene.surfaces[0].magneticForce = 0.8;
    b.scene.surfaces[0].magneticDistance = 0.01 * scale;
    b.scene.materials[0].surface = 0;
    b.addPart(boxMesh(glm::dvec3(0.04 * scale)));
    HandProbe hand(b.scene, springOnly(1000.0 / scale));
    // Loops in and out of reach over the corner (0.02, 0.02, 0.02), an edge and both faces beside it.
    constexpr int kSteps = 4000;
    const auto place = [&](int i) {
      const double a = 2.0 * kPi * i / kSteps;
      return scale * glm::dvec3(0.021 + 0.006 * std::cos(a), 0.016 + 0.007 * std::sin(2.0 * a),
                                0.0255 + 0.005 * std::sin(a));
    };
    double work = 0.0, facesOnly = 0.0, most = 0.0;
    glm::dvec3 before = hand.at(place(0)).hands[0].toHand.force;
    for (int i = 1; i <= kSteps; ++i) {
      const glm::dvec3 now = hand.at(place(i)).hands[0].toHand.force, step = place(i) - place(i - 1);
      work += glm::dot(0.5 * (before + now), step);
      // Negative control: a pull that ends where the faces end.
      if (place(i).x < 0.02 * scale && place(i).y < 0.02 * scale)
        facesOnly += glm::dot(0.5 * (before + now), step);
      most = std::max(most, glm::length(now));
      before = now;
    }
    EXPECT_NEAR(most, 0.8, 1e-3) << scale;
    EXPECT_NEAR(work, 0.0, 1e-7 * scale) << scale;
    EXPECT_GT(std::abs(facesOnly), 1e-4 * scale) << scale;
  }
}

TEST(SurfaceEffects, MoreMagnetsThanCanActAtOnceAreFlagged) {
  SceneBuilder b;
  b.scene.surfaces.emplace_back();
  b.scene.surfaces[0].magneticForce = 0.1;
  b.scene.surfaces[0].magneticDistance = 0.05;
  b.scene.materials[0].surface = 0;
  const std::uint32_t ball = b.addMesh(sphereMesh(0.002, 8));
  for (int i = 0; i < 30; ++i)
    b.addPart(ball, {{0.01 * std::cos(0.2 * i), 0.01 * std::sin(0.2 * i), 0.0}, {1.0, 0.0, 0.0, 0.0}});
  HandProbe hand(b.scene, springOnly(1000.0));
  const haptics::TickOutput& out = hand.at({0.0, 0.0, 0.01});
  EXPECT_NE(out.flags & haptics::kFlagOverflow, 0u);
  EXPECT_LT(out.hands[0].toHand.force.z, 0.0) << "four of them pull all the same";
}

TEST(SurfaceEffects, NoSpringOfASurfaceIsStifferThanTheDeviceBears) {
  Surface surface;
  surface.texture.pattern = assets::SurfaceTexture::Pattern::sine;  // so that it takes the surface's own way
  surface.texture.amplitude = 1e-9;
  surface.texture.wavelength = 0.004;
  surface.stickSlipForce = 10.0;
  surface.stickSlipStiffness = 3000.0;
  haptics::TickParameters limited = springOnly(1000.0);
  limited.stiffnessLimit = 250.0;
  HandProbe hand(sheetOf(surface), limited);
  const auto press = [](HandProbe& probe) {
    probe.at({0.0, 0.0012, 0.005});
    probe.to({0.0, 0.0012, -0.002}, 1e-4);
  };
  press(hand);
  EXPECT_NEAR(hand.out.hands[0].toHand.force.z, 250.0 * 0.002, 1e-5);
  hand.at({0.001, 0.0012, -0.002});
  EXPECT_NEAR(hand.out.hands[0].toHand.force.x, -250.0 * 0.001, 1e-5);

  surface = Surface{};
  surface.law = Surface::Law::viscoelastic;
  surface.stiffness2 = 3000.0;
  surface.relaxation = 1e9;  // never: both springs act for good
  HandProbe relaxing(sheetOf(surface), limited);
  press(relaxing);
  EXPECT_NEAR(relaxing.out.hands[0].toHand.force.z, 250.0 * 0.002, 1e-5);
  HandProbe free(sheetOf(surface), springOnly(1000.0));
  press(free);
  EXPECT_NEAR(free.out.hands[0].toHand.force.z, 4000.0 * 0.002, 1e-5)
      << "without a limit it is as the file has it";
}

TEST(SurfaceEffects, PlasticSurfaceKeepsItsDentInPlace) {
  Surface surface;
  surface.law = Surface::Law::plastic;
  surface.yieldForce = 1.0;
  surface.hardening = 100.0;
  HandProbe hand(sheetOf(surface), springOnly(1000.0));
  const auto press = [&hand](double x, double depth) {
    hand.to({x, 0.0012, 0.005}, 1e-4);
    hand.to({x, 0.0012, -depth}, 1e-4);
    return hand.out.hands[0].toHand.force.z;
  };
  hand.at({0.0, 0.0012, 0.005});
  EXPECT_NEAR(press(0.0, 0.003), 1.0 + 0.002 * 1000.0 * 100.0 / 1100.0, 1e-6);
  EXPECT_NEAR(press(0.0, 0.001), 0.0, 1e-9) << "the dent is there";
  EXPECT_NEAR(press(0.05, 0.001), 1.0, 1e-6) << "and nowhere else";
}

TEST(SurfaceEffects, AnEmptyDentNeitherDampsNorDragsNorHolds) {
  for (const double viscosity : {0.0, 10.0}) {
    for (const double stickSlip : {0.0, 0.5}) {
      Surface surface;
      surface.law = Surface::Law::plastic;
      surface.yieldForce = 0.5;
      surface.viscosity = viscosity;
      surface.stickSlipForce = stickSlip;
      surface.stickSlipStiffness = stickSlip > 0.0 ? 200.0 : 0.0;
      haptics::TickParameters damped = springOnly(1000.0);
      damped.damping = 10.0;
      HandProbe hand(sheetOf(surface), damped);
      hand.at({0.0, 0.0012, 0.005});
      hand.to({0.0, 0.0012, -0.004}, 1e-4);
      EXPECT_GT(hand.out.hands[0].toHand.force.z, 1.0) << "damped while it yields";
      hand.to({0.0, 0.0012, 0.005}, 1e-4);
      double deepest = 0.0, most = 0.0;
      for (double z = 0.005; z > -0.0045; z -= 1e-4) {
        hand.at({0.0, 0.0012, z});
        const double force = glm::length(hand.out.hands[0].toHand.force);
        if (z > -0.0033) deepest = std::max(deepest, force);
        most = std::max(most, force);
      }
      EXPECT_NEAR(deepest, 0.0, 1e-9) << viscosity << ' ' << stickSlip;
      EXPECT_GT(most, 1.0) << "at its ground it is felt";
    }
  }
}

}  // namespace
}  // namespace tandem::test
