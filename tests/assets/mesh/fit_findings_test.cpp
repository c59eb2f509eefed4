// Which shafts and bores are cut too coarsely for the clearance between them.

#include "assets/mesh/fit_findings.h"

#include <gtest/gtest.h>

#include "assets/mesh/cylinders.h"
#include "tests/support/part_meshes.h"
#include "tests/support/shapes.h"

namespace tandem::test {
namespace {

constexpr double kRadius = 0.01;

/// A peg of 20 mm less the clearance (of diameters, m) above its bore, as many segments on both.
assets::Scene pegAndBore(double clearance, int segments, Fit fit = Fit::within, double scale = 1.0,
                         double aside = 0.0) {
  Peg peg;
  peg.radius = scale * (kRadius - 0.5 * clearance);
  peg.length *= scale;
  peg.chamfer *= scale;
  peg.facets = {segments, 4};
  BoredBlock block;
  block.boreRadius = scale * kRadius;
  block.depth *= scale;
  block.width *= scale;
  block.height *= scale;
  block.chamfer = scale * 0.5e-3;
  block.fit = fit;
  block.facets = {segments, 3};
  SceneBuilder builder;
  builder.addPart(meshOf(pegSoup(peg)), {{scale * aside, 0.0, scale * 0.005}, {1.0, 0.0, 0.0, 0.0}}, 0.1);
  builder.addPart(meshOf(boredBlockSoup(block)));
  return builder.scene;
}

TEST(Cylinders, OfAPegAreFoundAsTheyWereMade) {
  const Peg peg{0.01, 0.04, 0.001, {48, 5}};
  const std::vector<assets::Cylinder> found = assets::findCylinders(meshOf(pegSoup(peg)));
  ASSERT_EQ(found.size(), 1u) << "its chamfer is a cone";
  EXPECT_NEAR(found[0].radius, 0.01, 1e-9);
  EXPECT_EQ(found[0].segments, 48);
  EXPECT_FALSE(found[0].hollow);
  EXPECT_NEAR(std::abs(found[0].axis.z), 1.0, 1e-9);
  EXPECT_NEAR(found[0].middle.x, 0.0, 1e-9);
  EXPECT_NEAR(found[0].middle.z, 0.0205, 1e-6);
  EXPECT_NEAR(found[0].halfLength, 0.0195, 1e-6);
  EXPECT_NEAR(found[0].sag(), chordSag(0.01, 48), 1e-9);
}

TEST(Cylinders, OfABoreAreHollow) {
  const assets::Scene scene = pegAndBore(2e-5, 96);
  const std::vector<assets::Cylinder> found = assets::findCylinders(scene.meshes[1]);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_TRUE(found[0].hollow);
  EXPECT_EQ(found[0].segments, 96);
  EXPECT_NEAR(found[0].radius, kRadius, 1e-9);
}

TEST(Cylinders, BallsBoxesAndThreadsHaveNone) {
  for (const Facets facets : {Facets{48, 24}, Facets{40, 20}, Facets{96, 12}})
    EXPECT_TRUE(assets::findCylinders(meshOf(ballSoup(0.01, facets))).empty()) << facets.segments;
  EXPECT_TRUE(assets::findCylinders(meshOf(boxSoup(glm::dvec3(0.01), 6))).empty());
  EXPECT_TRUE(assets::findCylinders(meshOf(boltThreadSoup({}))).empty());
}

TEST(FitFindings, FortySegmentsAreTooFewForTwentyMicrometres) {
  for (const Fit fit : {Fit::within, Fit::around}) {
    const std::vector<assets::Finding> findings = assets::fitFindings(pegAndBore(2e-5, 40, fit));
    ASSERT_EQ(findings.size(), 1u);
    EXPECT_EQ(findings[0].code, "coarse-fit");
    EXPECT_EQ(findings[0].where, "part0");
    EXPECT_EQ(findings[0].count, 1u);
    EXPECT_NE(findings[0].message.find("with 40 segments"), std::string::npos) << findings[0].message;
    // pi / sqrt(0.02 mm / 20 mm) = 99.3 with the bore's radius; the peg's is 10 um less.
    EXPECT_NE(findings[0].message.find("at least 100 segments are needed"), std::string::npos)
        << findings[0].message;
  }
}

TEST(FitFindings, EnoughSegmentsAreEnough) {
  for (const Fit fit : {Fit::within, Fit::around})
    for (const int segments : {104, 192})
      EXPECT_TRUE(assets::fitFindings(pegAndBore(2e-5, segments, fit)).empty()) << segments;
  EXPECT_TRUE(assets::fitFindings(pegAndBore(5e-4, 40)).empty()) << "0.5 mm need 20";
  EXPECT_FALSE(assets::fitFindings(pegAndBore(2e-5, 96)).empty());
}

TEST(FitFindings, DoNotDependOnTheUnit) {
  for (const double scale : {1e-3, 20.0}) {
    EXPECT_EQ(assets::fitFindings(pegAndBore(2e-5, 40, Fit::within, scale)).size(), 1u) << scale;
    EXPECT_TRUE(assets::fitFindings(pegAndBore(2e-5, 104, Fit::within, scale)).empty()) << scale;
  }
}

TEST(FitFindings, ConcernOnlyWhatStandsInLineAndCanBeMoved) {
  EXPECT_TRUE(assets::fitFindings(pegAndBore(2e-5, 40, Fit::within, 1.0, 0.03)).empty());
  assets::Scene scene = pegAndBore(2e-5, 40);
  scene.parts[0].movable = false;
  EXPECT_TRUE(assets::fitFindings(scene).empty());
}

}  // namespace
}  // namespace tandem::test
