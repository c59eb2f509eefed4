// A 20 mm peg with a chamfer over its bore: tilted, offset, trembling, 20 mm/s.

#include <numbers>

#include "assets/mesh/fit_findings.h"
#include "tests/haptics/contact/part_contact_case.h"

namespace tandem::test {
namespace {

constexpr double kInserted = 0.15e-3;  // m, from the depth that the device wants

void expectInserted(const PegCase& peg) {
  HeldPartRig rig(pegCase(peg));
  rig.run(20);
  report(rig);
  expectSound(rig);
  const std::string& name = rig.given().name;
  EXPECT_NEAR(rig.last().part.position.z, rig.last().device.position.z, kInserted) << name;
  EXPECT_LE(rig.deepest(), kSteadyDepth) << name;
}

/// One peg; all twenty, at two tessellations, at full size.
void expectInsertedFor(double clearance) {
  for (std::uint32_t seed = 0; seed < (atFullSize() ? 20u : 1u); ++seed) {
    expectInserted({.diametralClearance = clearance, .triangles = 5'000, .seed = seed});
    if (atFullSize()) expectInserted({.diametralClearance = clearance, .triangles = 50'000, .seed = seed});
  }
}

TEST(TightPeg, GoesInWithHalfAMillimetre) { expectInsertedFor(0.5e-3); }

TEST(TightPeg, GoesInWithATenthOfAMillimetre) { expectInsertedFor(0.1e-3); }

TEST(TightPeg, GoesInWithTwentyMicrometres) { expectInsertedFor(0.02e-3); }

TEST(TightPeg, GoesInWithHalfAMillionTriangles) {
  if (!atFullSize()) GTEST_SKIP() << "set TANDEM_FULL_SIZE";
  for (std::uint32_t seed = 0; seed < 20; ++seed) {
    expectInserted({.diametralClearance = 0.02e-3, .triangles = 500'000, .seed = seed});
  }
}

/// Cut into 40 segments, a shaft of 20 mm has flats 31 um under its round, and here a play of 20 um.
constexpr int kCoarse = 40;
PegCase cutTooCoarsely() {
  return {.diametralClearance = 0.02e-3,
          .tremor = 0.0,
          .depth = 0.003,
          .settle = 0.1,
          .fit = Fit::within,
          .segments = kCoarse};
}

TEST(TightPeg, OfFortySegmentsIsWarnedOf) {
  for (const Fit fit : {Fit::around, Fit::within}) {
    PegCase peg = cutTooCoarsely();
    peg.fit = fit;
    const std::vector<assets::Finding> findings = assets::fitFindings(pegCase(peg).scene);
    ASSERT_EQ(findings.size(), 1u);
    EXPECT_EQ(findings[0].code, "coarse-fit");
    EXPECT_NE(findings[0].message.find("40 segments"), std::string::npos) << findings[0].message;
    peg.segments = 104;
    EXPECT_TRUE(assets::fitFindings(pegCase(peg).scene).empty());
  }
}

/// How deep such a peg comes, turned by a share of a segment, m.
double depthOfCoarsePeg(Fit fit, double segmentsTurned) {
  PegCase peg = cutTooCoarsely();
  peg.fit = fit;
  peg.spin = segmentsTurned * 2.0 * std::numbers::pi / kCoarse;
  HeldPartRig rig(pegCase(peg));
  rig.run(50);
  report(rig);
  expectSound(rig);
  EXPECT_LE(rig.deepest(), kSteadyDepth) << segmentsTurned;
  return -rig.last().part.position.z;
}

TEST(TightPeg, OfFortySegmentsDoesWhatItsFlatsDo) {
  // A bore as a CAD program cuts it: corners go into corners only. Between them the chamfer, at 45 degrees
  // from 1 mm within the radius on, stops where its corners meet the flats.
  const double flats = (kPegRadius + 0.01e-3) * std::cos(std::numbers::pi / kCoarse);
  EXPECT_NEAR(depthOfCoarsePeg(Fit::within, 0.5), flats - (kPegRadius - 0.001), 10e-6);
  if (!atFullSize()) return;
  EXPECT_NEAR(depthOfCoarsePeg(Fit::within, 0.25), 0.001, 40e-6);
  constexpr double kIn = 0.002;  // m, deeper than the chamfer is long, and still going
  EXPECT_GT(depthOfCoarsePeg(Fit::within, 0.0), kIn);
  // With flats around the round there is room however the peg is turned.
  for (const double turned : {0.0, 0.25, 0.5}) EXPECT_GT(depthOfCoarsePeg(Fit::around, turned), kIn);
}

TEST(TightPeg, ThickerThanItsBoreStaysOut) {
  // The control of the tests above.
  HeldPartRig rig(pegCase({.diametralClearance = -0.04e-3, .depth = 0.005}));
  rig.run(20);
  report(rig);
  expectSound(rig);
  EXPECT_GT(rig.last().part.position.z, -0.0012);  // the chamfer goes in
  EXPECT_LE(rig.deepest(), kSteadyDepth);
}

TEST(TightPeg, BeyondItsChamferRestsOnTheTop) {
  HeldPartRig rig(pegOnTopCase());
  rig.run(5);
  report(rig);
  expectSound(rig);
  EXPECT_NEAR(rig.last().part.position.z, 0.0, 0.1e-3);  // it leans on the rim on one side
  EXPECT_LE(rig.deepest(), kSteadyDepth);
  EXPECT_LT(rig.driftOver(0.2), 1e-6);
}

}  // namespace
}  // namespace tandem::test
