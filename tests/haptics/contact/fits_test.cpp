// Parts that stand in each other as the file has them, because one is modelled larger than its seat: they
// come out the way they went in, and all other contact acts as usual.

#include "tests/haptics/contact/part_contact_case.h"
#include "tests/support/soup_builder.h"

namespace tandem::test {
namespace {

constexpr double kHalfTurn = 3.14159265358979323846;  // rad
constexpr double kSeat = 0.010;                       // m, radius or half width of the seat
constexpr double kSeatThickness = 0.020;              // m, of the plate
constexpr double kHeadRadius = 0.016;                 // m
constexpr double kPlugMass = 0.05;                    // kg, at every scale: the hand is the same

/// A solid of revolution about the z axis. `profile`: the radius and the height of each ring, from the middle
/// of the lowest face to that of the top face.
assets::TriangleSoup turnedSoup(const std::vector<glm::dvec2>& profile, int around, double spin = 0.0) {
  SoupBuilder b;
  std::vector<Ring> rings;
  for (std::size_t k = 1; k + 1 < profile.size(); ++k) {
    Ring& ring = rings.emplace_back();
    for (int i = 0; i < around; ++i) {
      const double angle = spin + 2.0 * kHalfTurn * i / around;
      ring.emplace_back(profile[k].x * std::cos(angle), profile[k].x * std::sin(angle), profile[k].y);
    }
  }
  b.fan(rings.front(), {0.0, 0.0, profile.front().y}, SoupBuilder::Facing::down);
  b.bands(rings);
  b.fan(rings.back(), {0.0, 0.0, profile.back().y}, SoupBuilder::Facing::up);
  return b.soup;
}

struct Fitted {
  double oversize = 0.1e-3;  // m, of the radius or half width, before scaling
  double scale = 1.0;
  bool through = true;   // the bolt's tip comes out of the plate below
  int around = 48;       // corners of the bolt
  double ringDepth = 0;  // m, of the grooves of a bolt of rings
  bool key = false;      // a key in a slot
};

assets::TriangleSoup scaled(assets::TriangleSoup soup, double by) {
  for (glm::dvec3& p : soup.positions) p *= by;
  return soup;
}

/// Its head's underside lies in z = 0.
assets::TriangleSoup boltOf(const Fitted& fit) {
  const double radius = kSeat + fit.oversize, length = fit.through ? 0.030 : 0.015;
  std::vector<glm::dvec2> profile{{0.0, -length}};
  if (fit.ringDepth > 0.0) {
    constexpr double kPitch = 0.0025;
    for (double z = -length; z < -0.5 * kPitch; z += kPitch) {
      profile.insert(profile.end(), {{radius, z},
                                     {radius, z + 0.3 * kPitch},
                                     {radius - fit.ringDepth, z + 0.5 * kPitch},
                                     {radius - fit.ringDepth, z + 0.8 * kPitch}});
    }
  } else {
    profile.push_back({radius, -length});
  }
  profile.insert(profile.end(), {{radius, 0.0}, {kHeadRadius, 0.0}, {kHeadRadius, 0.008}, {0.0, 0.008}});
  return turnedSoup(profile, fit.around, 0.01);
}

/// The seat's top is z = 0.
assets::TriangleSoup seatOf(const Fitted& fit) {
  if (fit.key) return moved(slotSoup(2.0 * kSeat, 0.008, 0.015, 0.05), {0.0, 0.0, -0.008});
  return boredBlockSoup({.boreRadius = kSeat,
                         .depth = kSeatThickness,
                         .width = 0.060,
                         .height = fit.through ? kSeatThickness : 0.03,
                         .fit = Fit::within,
                         .facets = {64, 4}});
}

assets::TriangleSoup plugOf(const Fitted& fit) {
  if (!fit.key) return boltOf(fit);
  return moved(boxSoup({2.0 * (kSeat + fit.oversize), 0.03, 0.012}), {0.0, 0.0, -0.002});
}

/// The plug goes along `path`, in seats of scale 1, in `duration` s at scale 1; at ten times that, it takes
/// longer, so that the hand stays slow.
PartCase fitted(const Fitted& fit, const std::function<glm::dvec3(double)>& path, double duration) {
  assets::Scene scene = sceneOfParts(
      {{.name = "seat", .mesh = meshOf(scaled(seatOf(fit), fit.scale))},
       {.name = "plug", .mesh = meshOf(scaled(plugOf(fit), fit.scale)), .movable = true, .mass = kPlugMass}});
  const double slow = std::max(fit.scale, 1.0) > 1.0 ? 5.0 : 1.0;
  const DevicePath led = [=](double time) {
    return Pose{fit.scale * path(time / slow), glm::dquat(1.0, 0.0, 0.0, 0.0)};
  };
  return {"fitted", std::move(scene), 1, led, slow * duration, {}};
}

double smooth(double share) { return 0.5 - 0.5 * std::cos(kHalfTurn * std::clamp(share, 0.0, 1.0)); }

/// Straight out, by 40 mm in 0.8 s.
glm::dvec3 out(double time) { return {0.0, 0.0, 0.04 * smooth(time / 0.8)}; }

void expectDrawnOut(const Fitted& fit) {
  SCOPED_TRACE(testing::Message() << "oversize " << 1e6 * fit.oversize << " um, scale " << fit.scale
                                  << ", through " << fit.through << ", around " << fit.around);
  HeldPartRig rig(fitted(fit, out, 0.9));
  rig.run(0);
  expectSound(rig);
  report(rig);
  EXPECT_LT(rig.mostForce(), 0.5);
  EXPECT_LT(quantile(rig.forceSteps(), 1.0), 0.25);
  EXPECT_NEAR(rig.last().part.position.z, 0.04 * fit.scale, 1e-4 * fit.scale + 1e-5);
  EXPECT_LT(glm::length(glm::dvec2(rig.last().part.position)), 1e-4 * fit.scale);
}

class Fits : public testing::TestWithParam<double> {};  // scales

TEST_P(Fits, ABoltComesOutOfAThroughHole) {
  for (const double oversize : {10e-6, 100e-6, 500e-6}) {
    if (GetParam() <= 1.0 || oversize == 100e-6 || atFullSize())
      expectDrawnOut({.oversize = oversize, .scale = GetParam()});
  }
}

TEST_P(Fits, ABoltComesOutOfABlindHole) {
  for (const double oversize : {10e-6, 500e-6}) {
    if (GetParam() <= 1.0 || atFullSize())
      expectDrawnOut({.oversize = oversize, .scale = GetParam(), .through = false});
  }
}

TEST_P(Fits, AKeyComesOutOfItsSlot) { expectDrawnOut({.oversize = 50e-6, .scale = GetParam(), .key = true}); }

TEST_P(Fits, ABoltOfRingsComesOut) {
  if (GetParam() == 1.0 || atFullSize())
    expectDrawnOut({.oversize = 300e-6, .scale = GetParam(), .ringDepth = 0.6e-3});
}

INSTANTIATE_TEST_SUITE_P(AllScales, Fits, testing::Values(1e-2, 1.0, 10.0));

/// m that the plug's axis has gone aside where the plate's top is.
double aside(const HeldPartRig& rig) {
  const Pose& part = rig.last().part;
  return glm::length(glm::dvec2(transformPoint(part, {0.0, 0.0, -part.position.z})));
}

TEST(FitsHold, APushAside) {
  for (const double height : {0.0, 0.01}) {
    const auto path = [=](double time) {
      return glm::dvec3(0.002 * smooth((time - 0.4) / 0.2), 0.0, height * smooth(time / 0.3));
    };
    HeldPartRig rig(fitted({.oversize = 100e-6}, path, 0.8));
    rig.run(0);
    EXPECT_GT(rig.mostForce(0.7), 1.0);
    EXPECT_LT(aside(rig), 20e-6) << height;
  }
}

TEST(FitsHold, TheHead) {
  const auto path = [](double time) { return glm::dvec3(0.0, 0.0, -0.002 * smooth(time / 0.3)); };
  HeldPartRig rig(fitted({.oversize = 500e-6}, path, 0.6));
  rig.run(0);
  EXPECT_GT(rig.mostForce(0.5), 1.5);
  EXPECT_GT(rig.last().part.position.z, -kSteadyDepth);
}

TEST(FitsHold, WhatGoesBackIn) {
  for (const double oversize : {10e-6, 500e-6}) {
    const auto path = [](double time) {
      return glm::dvec3(0.0, 0.0, 0.04 * (smooth(time / 0.6) - smooth((time - 0.8) / 0.6)) - 1e-4);
    };
    HeldPartRig rig(fitted({.oversize = oversize}, path, 1.6));
    rig.run(0);
    report(rig);
    EXPECT_LT(rig.mostForce(), 0.5) << oversize;
    EXPECT_LT(quantile(rig.forceSteps(), 1.0), 0.25) << oversize;
    EXPECT_NEAR(rig.last().part.position.z, 0.0, kSteadyDepth) << oversize;
  }
}

/// m, how deep the rim of the bolt's tip is in the plate beside the hole.
double tipInPlate(const HeldPartRig& rig) {
  double deepest = 0.0;
  for (int i = 0; i < 360; ++i) {
    const glm::dvec3 rim((kSeat + 500e-6) * std::cos(i * kHalfTurn / 180.0),
                         (kSeat + 500e-6) * std::sin(i * kHalfTurn / 180.0), -0.03);
    const glm::dvec3 p = transformPoint(rig.last().part, rim);
    if (glm::length(glm::dvec2(p)) > kSeat + 600e-6) deepest = std::max(deepest, -p.z);
  }
  return deepest;
}

/// Out of its hole the bolt is let down beside it: its tip stands on the plate.
TEST(FitsHold, TheSurfaceBesideTheHole) {
  const double aside = 0.015;
  const auto path = [=](double time) {
    return glm::dvec3(aside * smooth((time - 0.5) / 0.2), 0.0,
                      0.04 * smooth(time / 0.4) - 0.012 * smooth((time - 0.8) / 0.3));
  };
  HeldPartRig rig(fitted({.oversize = 500e-6}, path, 1.3));
  rig.run(0);
  EXPECT_GT(rig.mostForce(1.2), 1.0);
  EXPECT_LT(tipInPlate(rig), kSteadyDepth);
}

}  // namespace
}  // namespace tandem::test
