// Surfaces under the part in the hand.

#include <memory>
#include <random>

#include "tests/haptics/grasp/through_part.h"

namespace tandem::test {
namespace {

using assets::Surface;
using assets::SurfaceTexture;

/// The bar on a plate of one surface in z = 0, pressed on it with 1 N.
std::unique_ptr<BarInHand> barOn(const Surface& surface, double couplingDamping = 2.0, bool effects = true,
                                 double friction = 0.0) {
  SceneBuilder b;
  addBar(b, {0.0, 0.0, 0.05e-3});
  b.scene.surfaces.push_back(surface);
  b.scene.materials.emplace_back();
  if (effects) b.scene.materials[1].surface = 0;
  b.scene.materials[1].staticFriction = b.scene.materials[1].dynamicFriction = friction;
  assets::Mesh plate = boxMesh({0.2, 0.2, 0.02});
  for (std::uint16_t& material : plate.triangleMaterial) material = 1;
  b.addPart(plate, {{0.0, 0.0, -0.01}, {1.0, 0.0, 0.0, 0.0}});
  auto hand = std::make_unique<BarInHand>(b.scene, 0, couplingDamping);
  for (int i = 0; i < 105; ++i) hand->by({0.0, 0.0, -1e-5});
  hand->rest(300);
  EXPECT_NEAR(hand->force().z, 1.0, 0.02 + surface.vibrationAmplitude);
  return hand;
}

Surface sine(double wavelength, double amplitude) {
  Surface surface;
  surface.texture.pattern = SurfaceTexture::Pattern::sine;
  surface.texture.wavelength = wavelength;
  surface.texture.amplitude = amplitude;
  return surface;
}

struct Stroke {
  double least = 1e300, most = -1e300;  // N, along the stroke
};

Stroke stroke(BarInHand& hand, double speed, int ticks) {
  Stroke out;
  for (int i = 0; i < ticks; ++i) {
    hand.by({speed * 1e-3, 0.0, 0.0});
    if (i < ticks / 2) continue;
    out.least = std::min(out.least, hand.force().x);
    out.most = std::max(out.most, hand.force().x);
  }
  return out;
}

/// A stroke over a plate of that surface under 1 N.
Stroke strokeOver(const Surface& surface, double speed, int ticks, bool effects = true) {
  return stroke(*barOn(surface, 2.0, effects), speed, ticks);
}

TEST(HeldSurfaces, ReliefIsFeltAlongTheSlip) {
  // N dh/dx = 1 N * 0.05 mm * 2 pi / 2 mm = 0.157 N either way.
  const Stroke felt = strokeOver(sine(2e-3, 0.05e-3), 0.02, 1000);
  EXPECT_NEAR(felt.most, 0.157, 0.03);
  EXPECT_NEAR(felt.least, -0.157, 0.03);
  const Stroke without = strokeOver(sine(2e-3, 0.05e-3), 0.02, 1000, false);
  EXPECT_LT(without.most - without.least, 0.01);
}

TEST(HeldSurfaces, ReliefFollowsTheContactForce) {
  const auto made = barOn(sine(2e-3, 0.05e-3));
  BarInHand& hand = *made;
  for (int i = 0; i < 100; ++i) hand.by({0.0, 0.0, -1e-5});  // 2 N
  EXPECT_NEAR(stroke(hand, 0.02, 1000).most, 0.314, 0.06);
}

TEST(HeldSurfaces, FrictionIsThatOfItsMap) {
  // All corners of the bar are on waves of one phase. Half of 0.2 and the bar's 0, once to four times.
  Surface surface = sine(10e-3, 0.0);
  surface.texture.frictionScale = 4.0;
  const auto strokeWith = [&](bool effects) {
    return stroke(*barOn(surface, 2.0, effects, 0.2), 0.02, 1000);
  };
  const Stroke felt = strokeWith(true), without = strokeWith(false);
  EXPECT_NEAR(felt.least, -0.4, 0.03);
  EXPECT_NEAR(felt.most, -0.1, 0.02);
  EXPECT_NEAR(without.least, -0.1, 0.01);
  EXPECT_NEAR(without.most, -0.1, 0.01);
}

TEST(HeldSurfaces, ViscosityDragsThePart) {
  Surface surface;
  surface.viscosity = 3.0;
  const Stroke felt = strokeOver(surface, 0.1, 400);
  EXPECT_NEAR(felt.least, -0.3, 0.03);
}

TEST(HeldSurfaces, StickSlipHoldsUntilItsForce) {
  Surface surface;
  surface.stickSlipForce = 0.5;
  surface.stickSlipStiffness = 2000.0;
  const Stroke felt = strokeOver(surface, 0.01, 1500);
  EXPECT_NEAR(felt.least, -0.5, 0.1);
  EXPECT_GT(felt.most - felt.least, 0.2) << "it slips";
}

TEST(HeldSurfaces, VibrationShakesTheHandNoHarderThanItPresses) {
  Surface surface;
  surface.vibrationAmplitude = 0.4;
  surface.vibrationFrequency = 50.0;
  const auto made = barOn(surface);
  BarInHand& hand = *made;
  double least = 1e300, most = -1e300;
  for (int i = 0; i < 200; ++i) {
    hand.rest(1);
    least = std::min(least, hand.force().z);
    most = std::max(most, hand.force().z);
  }
  EXPECT_NEAR(most - least, 0.8, 0.05);
  for (int i = 0; i < 85; ++i) hand.by({0.0, 0.0, 1e-5});  // 0.15 N are left
  for (int i = 0; i < 200; ++i) {
    hand.rest(1);
    EXPECT_GT(hand.force().z, -0.02);
  }
}

/// J to the hand over a stroke along 2 mm waves of 0.1 mm that presses harder downhill than uphill. `unpaid`:
/// what -N dh/dx gives on the same way if nothing limits it.
double givenByUnevenPress(bool effects, std::uint32_t seed, double& unpaid) {
  const Surface surface = sine(2e-3, 0.1e-3);
  const auto made = barOn(surface, 0.0, effects);
  BarInHand& hand = *made;
  hand.given = 0.0;
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> noise(-1e-5, 1e-5);
  double pressed = 0.0;
  for (int i = 0; i < 3000; ++i) {
    const double slope = 0.1e-3 * 2.0 * kPi / 2e-3 * std::cos(2.0 * kPi * hand.device().x / 2e-3);
    const double z = 0.2 * ((slope < 0.0 ? -1e-3 : 0.0) - pressed);  // downhill 2 N, uphill 1 N
    pressed += z;
    unpaid -= hand.force().z * slope * 1e-5;
    hand.by({1e-5, noise(random), z});
  }
  return hand.given;
}

TEST(HeldSurfaces, ReliefGivesNothingToWhoPressesHarderDownhill) {
  double unpaid = 0.0, none = 0.0;
  const double relief = givenByUnevenPress(true, 1, unpaid), plain = givenByUnevenPress(false, 1, none);
  EXPECT_LT(relief - plain, 2e-5) << "what the plain plate gives is the coupling's";
  EXPECT_GT(unpaid, 1e-3) << "the control: a force that nobody pays for";
}

TEST(HeldSurfaces, DragGivesNoEnergyWhateverItsStrength) {
  for (const double viscosity : {1.0, 30.0, 3000.0}) {
    for (const double stiffness : {100.0, 3000.0, 1e6}) {
      Surface surface;
      surface.viscosity = viscosity;
      surface.stickSlipForce = 2.0;
      surface.stickSlipStiffness = stiffness;
      const auto made = barOn(surface, 0.0);
      BarInHand& hand = *made;
      hand.given = hand.sampling = 0.0;
      const double spring = 0.5 * glm::dot(hand.force(), hand.force()) / BarInHand::kStiffness;
      std::mt19937 random(7);
      std::uniform_real_distribution<double> kick(-3e-4, 3e-4);
      for (int i = 0; i < 800; ++i) hand.by({kick(random), kick(random), 0.0});
      EXPECT_LT(hand.given - hand.sampling - spring, 1e-6) << viscosity << ' ' << stiffness;
    }
  }
}

TEST(HeldSurfaces, DragThatIsNotHeldToWhatTheMassBearsWouldGrow) {
  // The control of the test above: 3000 N·s/m on 60 g, held for a tick.
  double v = 1e-3;
  for (int i = 0; i < 10; ++i) v -= 1e-3 * 3000.0 * v / 0.06;
  EXPECT_GT(std::abs(v), 1.0);
}

}  // namespace
}  // namespace tandem::test
