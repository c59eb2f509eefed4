// The sample scene of surfaces, plate by plate: what it feels like is what its material says.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "assets/gltf/load_gltf.h"
#include "haptics/scene/haptic_texture.h"
#include "tests/haptics/hand_probe.h"
#include "tests/support/source_file.h"

namespace tandem::test {
namespace {

constexpr double mm = 1e-3;
constexpr double kSide = 36.0 * mm, kHeight = 6.0 * mm;

const assets::Scene& scene() {
  static const assets::Scene loaded = [] {
    auto result = assets::loadGltf(sourceFile("assets/scenes/surfaces.glb"), {});
    if (!result.ok()) throw std::runtime_error(result.error().message);
    return std::move(*result);
  }();
  return loaded;
}

/// A point tool over one plate. x and z from its middle, depth under its top; y is up.
class Plate {
 public:
  explicit Plate(const char* name) : part(assets::findPart(scene(), name)), hand(scene()) {
    EXPECT_NE(part, kNoPart) << name;
    if (part != kNoPart) middle_ = scene().parts[part].worldFromPart.position + glm::dvec3(0.0, kHeight, 0.0);
  }

  const haptics::TickOutput& at(double x, double z, double depth) { return hand.at(place(x, z, depth)); }
  glm::dvec3 force() const { return hand.out.hands[0].toHand.force; }

  /// Comes down at 50 mm/s, and holds still for a tick.
  glm::dvec3 press(double x, double z, double depth) {
    if (hand.out.touched != part || hand.out.contactCount == 0) at(x, z, -5.0 * mm);
    hand.to(place(x, z, depth), 0.05 * mm);
    at(x, z, depth);
    return force();
  }

  /// Slides along x at `speed` m/s from the last place; the force at its end.
  glm::dvec3 slide(double from, double z, double depth, double speed, int ticks) {
    for (int i = 1; i <= ticks; ++i) at(from + speed * 1e-3 * i, z, depth);
    return force();
  }

  glm::dvec3 place(double x, double z, double depth) const { return middle_ + glm::dvec3(x, -depth, z); }

  PartId part;
  HandProbe hand;

 private:
  glm::dvec3 middle_{0.0};
};

void expectNear(const glm::dvec3& is, const glm::dvec3& should, double tolerance) {
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(is[i], should[i], tolerance) << "axis " << i;
}

TEST(SampleSurfaces, TheElasticPlateIsASpringAndNothingElse) {
  Plate plate("elastic");
  expectNear(plate.press(0.0, 0.0, 1.5 * mm), {0.0, 1.5, 0.0}, 1e-6);
  expectNear(plate.slide(0.0, 0.0, 1.5 * mm, 0.1, 50), {0.0, 1.5, 0.0}, 1e-6);
}

TEST(SampleSurfaces, TheDampedPlateResistsSpeed) {
  Plate plate("damping");
  expectNear(plate.press(0.0, 0.0, 1.0 * mm), {0.0, 0.6, 0.0}, 1e-6);
  plate.at(0.0, 0.0, 1.1 * mm);  // 0.1 m/s inwards
  expectNear(plate.force(), {0.0, 0.66 + 8.0 * 0.1, 0.0}, 1e-6);
}

TEST(SampleSurfaces, TheFrictionPlateHoldsUpToItsStaticAndSlidesAtItsDynamicFriction) {
  Plate plate("friction");
  plate.press(0.0, 0.0, 2.0 * mm);
  double held = 0.0;
  for (int i = 1; i <= 60; ++i) {
    const glm::dvec3 before = plate.hand.out.worldFromProxy.position;
    plate.at(0.05 * mm * i, 0.0, 2.0 * mm);
    if (plate.hand.out.worldFromProxy.position == before) held = -plate.force().x / plate.force().y;
  }
  EXPECT_NEAR(held, 0.8, 0.03);  // the next step, of 0.025 of the normal force, breaks away
  EXPECT_NEAR(-plate.force().x / plate.force().y, 0.5, 0.0025);
}

TEST(SampleSurfaces, TheFrictionMapGrowsFromLeftToRight) {
  for (const double x : {-12.0 * mm, 0.0, 12.0 * mm}) {
    Plate plate("friction map");
    plate.press(x - 4.0 * mm, 0.003, 1.0 * mm);
    const glm::dvec3 force = plate.slide(x - 4.0 * mm, 0.003, 1.0 * mm, 0.02, 200);
    const double proxy = plate.hand.out.worldFromProxy.position.x - plate.place(0.0, 0.0, 0.0).x;
    const double texel = (0.5 + proxy / kSide) * 128.0 - 0.5, height = 2.0 * texel / 255.0;
    EXPECT_NEAR(-force.x / force.y, 0.2 * (1.0 + 3.0 * height), 0.003) << x;
  }
}

TEST(SampleSurfaces, TheImageIsFeltAsHills) {
  const double turn = 6.0 * kPi, amplitude = 0.3 * mm;
  for (const glm::dvec2& uv :
       {glm::dvec2(1.0 / 3.0, 1.0 / 3.0), {0.5, 1.0 / 3.0}, {0.37, 0.4}, {0.62, 0.55}}) {
    Plate plate("image relief");
    const glm::dvec3 force = plate.press((uv.x - 0.5) * kSide, (uv.y - 0.5) * kSide, 1.0 * mm);
    const double depth = 1.0 * mm + amplitude * std::cos(turn * uv.x) * std::cos(turn * uv.y);
    const double slope = amplitude * turn / kSide;
    // 96 texels of 8 bits: the heights are a hundredth off, the slopes a few.
    EXPECT_NEAR(force.y, 1000.0 * depth, 0.01);
    EXPECT_NEAR(force.x, 1000.0 * depth * slope * std::sin(turn * uv.x) * std::cos(turn * uv.y), 0.02);
    EXPECT_NEAR(force.z, 1000.0 * depth * slope * std::cos(turn * uv.x) * std::sin(turn * uv.y), 0.02);
  }
}

TEST(SampleSurfaces, FormulasOfReliefAreFeltAsTheyStand) {
  const double turn = 2.0 * kPi / (4.0 * mm);
  for (const double x : {0.3 * mm, 1.1 * mm, 5.7 * mm}) {
    Plate waves("waves"), grid("grid"), bumps("bumps");
    const double depth = 1.0 * mm;
    const double wave = depth + 0.15 * mm * std::sin(turn * x);
    expectNear(waves.press(x, 0.0, depth),
               {-1000.0 * wave * 0.15 * mm * turn * std::cos(turn * x), 1000.0 * wave, 0.0}, 1e-5);
    // The lattice stands in the part: the top is 6 mm up, half a wave and one.
    const double mean = (std::sin(turn * x) + std::sin(turn * kHeight) + std::sin(turn * 0.7 * mm)) / 3.0;
    EXPECT_NEAR(grid.press(x, 0.7 * mm, depth).y, 1000.0 * (depth + 0.15 * mm * mean), 1e-5);
    const double across = std::remainder(x / (5.0 * mm), 1.0), up = std::remainder(kHeight / (5.0 * mm), 1.0);
    const double inside = std::max(0.0, 1.0 - 4.0 * (across * across + up * up));
    EXPECT_NEAR(bumps.press(x, 0.0, depth).y, 1000.0 * (depth + 0.25 * mm * (2.0 * inside * inside - 1.0)),
                1e-5);
  }
}

TEST(SampleSurfaces, NoiseIsTheGradientOfItsOwnHeight) {
  Plate plate("noise");
  double low = 1.0, high = 0.0;
  for (int i = 0; i < 40; ++i) {
    const double x = (-10.0 + 0.5 * i) * mm, e = 1e-6;
    const double left = plate.press(x - e, 0.002, 1.0 * mm).y, right = plate.press(x + e, 0.002, 1.0 * mm).y;
    const glm::dvec3 force = plate.press(x, 0.002, 1.0 * mm);
    EXPECT_NEAR(force.x, -force.y * (right - left) / (2.0 * e) / 1000.0, 1e-4);
    low = std::min(low, force.y), high = std::max(high, force.y);
  }
  EXPECT_GT(low, 0.8 - 1e-6);  // 0.2 mm at most
  EXPECT_LT(high, 1.2 + 1e-6);
  EXPECT_GT(high - low, 0.1);
}

TEST(SampleSurfaces, TheViscousPlateDragsBySpeed) {
  Plate plate("viscosity");
  plate.press(0.0, 0.0, 1.0 * mm);
  expectNear(plate.slide(0.0, 0.0, 1.0 * mm, 0.1, 20), {-0.6, 1.0, 0.0}, 1e-6);
}

TEST(SampleSurfaces, TheBuzzHasItsFrequencyAndAmplitude) {
  Plate plate("vibration");
  plate.press(0.0, 0.0, 1.0 * mm);
  int rises = 0;
  double before = plate.force().y, high = 0.0;
  for (int i = 0; i < 1000; ++i) {
    const double now = plate.at(0.0, 0.0, 1.0 * mm).hands[0].toHand.force.y;
    rises += before < 1.0 && now >= 1.0 ? 1 : 0;
    high = std::max(high, now);
    before = now;
  }
  EXPECT_NEAR(rises, 80, 1);
  EXPECT_NEAR(high, 1.4, 0.01);
}

TEST(SampleSurfaces, StickSlipLetsGoAtItsForce) {
  Plate plate("stick-slip");
  plate.press(0.0, 0.0, 1.0 * mm);
  int slips = 0;
  double strongest = 0.0, before = 0.0;
  for (int i = 1; i <= 600; ++i) {  // 12 mm; it holds for 0.6 / 500 = 1.2 mm
    const double now = -plate.at(0.02 * mm * i, 0.0, 1.0 * mm).hands[0].toHand.force.x;
    slips += now < before ? 1 : 0;
    strongest = std::max(strongest, now);
    before = now;
  }
  EXPECT_NEAR(slips, 10, 1);
  EXPECT_NEAR(strongest, 0.6, 0.011);
}

TEST(SampleSurfaces, TheMagnetPullsHardestAtHalfItsDistance) {
  Plate plate("magnet");
  EXPECT_EQ(plate.at(0.0, 0.0, -9.0 * mm).hands[0].toHand.force, glm::dvec3(0.0));
  expectNear(plate.at(0.0, 0.0, -4.0 * mm).hands[0].toHand.force, {0.0, -0.8, 0.0}, 1e-6);
  expectNear(plate.at(0.0, 0.0, -2.0 * mm).hands[0].toHand.force, {0.0, -0.8 * 0.75, 0.0}, 1e-6);
  expectNear(plate.press(0.0, 0.0, 1.0 * mm), {0.0, 1.0, 0.0}, 1e-6);
}

TEST(SampleSurfaces, ThePopThroughPlateGivesWayAboveItsForce) {
  Plate plate("pop-through");
  expectNear(plate.press(0.0, 0.0, 1.49 * mm), {0.0, 1.49, 0.0}, 1e-6);
  plate.at(0.0, 0.0, 1.51 * mm);
  EXPECT_NE(plate.hand.out.flags & haptics::kFlagPopThrough, 0u);
  EXPECT_EQ(plate.at(0.0, 0.0, 1.6 * mm).hands[0].toHand.force, glm::dvec3(0.0));
}

TEST(SampleSurfaces, TheViscoelasticPlateRelaxes) {
  Plate plate("viscoelastic");
  const double first = plate.press(0.0, 0.0, 1.0 * mm).y - 0.3;
  EXPECT_GT(first, 0.7);
  for (int i = 0; i < 250; ++i) plate.at(0.0, 0.0, 1.0 * mm);
  EXPECT_NEAR((plate.force().y - 0.3) / first, std::exp(-1.0), 1e-4);
}

TEST(SampleSurfaces, ThePlasticPlateKeepsItsDent) {
  Plate plate("plastic");
  const double force = 0.8 + 1.2 * mm * 1000.0 * 120.0 / 1120.0;  // it yields at 0.8 mm
  EXPECT_NEAR(plate.press(0.0, 0.0, 2.0 * mm).y, force, 1e-6);
  plate.at(0.0, 0.0, -1.0 * mm);
  EXPECT_NEAR(plate.press(0.0, 0.0, 2.0 * mm - force / 1000.0).y, 0.0, 1e-6) << "the dent";
  EXPECT_NEAR(plate.press(0.01, 0.0, 0.5 * mm).y, 0.5, 1e-6) << "beside it";
}

/// The largest angle between the force and the sphere's own normal around the dome, rad.
double roughness(const char* name) {
  Plate plate(name);
  const double radius = 20.0 * mm, up = 0.2 * kPi;
  const glm::dvec3 centre =
      plate.place(0.0, 0.0, kHeight) - glm::dvec3(0.0, radius * std::cos(0.35 * kPi), 0.0);
  double worst = 0.0;
  for (int i = 0; i <= 400; ++i) {
    const double around = 0.5 * kPi * i / 400.0;
    const glm::dvec3 n(std::sin(up) * std::cos(around), std::cos(up), std::sin(up) * std::sin(around));
    if (i == 0) plate.hand.at(centre + n * (radius + 2.0 * mm));
    plate.hand.at(centre + n * (radius - 1.0 * mm));
    const glm::dvec3 f = plate.force();
    worst = std::max(worst, std::acos(std::min(1.0, glm::dot(f, n) / glm::length(f))));
  }
  return worst;
}

TEST(SampleSurfaces, TheSmoothDomeFeelsRoundAndTheFacettedOneDoesNot) {
  const double smooth = roughness("smooth dome"), facets = roughness("facetted dome");
  RecordProperty("smooth_rad", std::to_string(smooth));
  EXPECT_LT(smooth, 0.03);
  EXPECT_GT(facets, 0.12) << "half of what its faces turn by";
}

}  // namespace
}  // namespace tandem::test
