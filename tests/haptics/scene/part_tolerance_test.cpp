// How exact contact of a part has to be follows from the clearance in which it stands, unless the file says
// so.

#include "haptics/scene/part_tolerance.h"

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include <cmath>
#include <utility>
#include <vector>

#include "haptics/overlap/mesh_overlap.h"
#include "haptics/scene/contact_scene_data.h"
#include "tests/support/part_cases.h"

namespace tandem::test {
namespace {

using haptics::ContactScene;
using haptics::PartTolerance;

constexpr double kSide = 0.1;
const double kDiagonal = kSide * std::sqrt(3.0);
const double kUsual = 0x1p-14 * kDiagonal;  // 10.6 um: what a scene of such cubes asks for by itself

Pose at(double x, double y = 0.0, double z = 0.0) { return Pose{{x, y, z}, {1.0, 0.0, 0.0, 0.0}}; }

CasePart cube(const char* name, const Pose& worldFromPart, double side = kSide, bool movable = true) {
  return {name, meshOf(boxSoup(glm::dvec3(side))), worldFromPart, movable};
}

/// Two cubes side by side along x, `gap` m apart.
assets::Scene sideBySide(double gap) {
  return sceneOfParts({cube("left", at(0.0)), cube("right", at(kSide + gap))});
}

std::vector<PartTolerance> tolerancesOf(const assets::Scene& scene, int threads = 1) {
  const ContactScene contact(scene, 1);
  double held = 1e300;
  for (const haptics::Collider& collider : contact.data().colliders)
    held = std::min(held, 2.0 * collider.radius);
  return haptics::partTolerances(scene, contact.data().colliders, held, threads);
}

void expectUsual(const assets::Scene& scene) {
  for (const PartTolerance& own : tolerancesOf(scene)) {
    EXPECT_EQ(own.from, PartTolerance::From::scene);
    EXPECT_NEAR(own.tolerance, kUsual, 1e-9 * kUsual);
  }
}

TEST(PartTolerances, AreAnEighthOfTheSmallestClearance) {
  const std::vector<PartTolerance> found = tolerancesOf(sideBySide(30e-6));
  for (PartId part = 0; part < 2; ++part) {
    EXPECT_EQ(found[part].from, PartTolerance::From::clearance);
    EXPECT_NEAR(found[part].clearance, 30e-6, 1e-12);
    EXPECT_NEAR(found[part].tolerance, 30e-6 / 8.0, 1e-12);
    EXPECT_EQ(found[part].neighbour, 1u - part);
  }
}

TEST(PartTolerances, OfSeveralClearancesTheSmallestCounts) {
  const assets::Scene scene = sceneOfParts(
      {cube("left", at(-kSide - 50e-6)), cube("middle", at(0.0)), cube("right", at(kSide + 20e-6))});
  const std::vector<PartTolerance> found = tolerancesOf(scene);
  EXPECT_NEAR(found[0].tolerance, 50e-6 / 8.0, 1e-12);
  EXPECT_NEAR(found[1].tolerance, 20e-6 / 8.0, 1e-12);
  EXPECT_EQ(found[1].neighbour, 2u);
  EXPECT_NEAR(found[2].tolerance, 20e-6 / 8.0, 1e-12);
}

TEST(PartTolerances, FarNeighboursLeaveWhatSuitsTheScene) {
  expectUsual(sideBySide(8.01 * kUsual));
  expectUsual(sideBySide(0.03));
  // Just near enough to count.
  EXPECT_EQ(tolerancesOf(sideBySide(7.99 * kUsual))[0].from, PartTolerance::From::clearance);
}

TEST(PartTolerances, TouchesAndOverlapsAreNoClearances) {
  expectUsual(sideBySide(0.0));
  expectUsual(sideBySide(-30e-6));
  // Flush but for the rounding of a file.
  expectUsual(sideBySide(1e-8));
  // Wholly inside, 30 um below the surface.
  const double small = 0.5 * kSide;
  const assets::Scene inside =
      sceneOfParts({cube("block", at(0.0)), cube("cube", at(0.5 * (kSide - small) - 30e-6), small)});
  for (const PartTolerance& own : tolerancesOf(inside)) EXPECT_EQ(own.from, PartTolerance::From::scene);
}

TEST(PartTolerances, AGivenOneWins) {
  for (const double given : {1e-6, 1e-3}) {
    assets::Scene scene = sideBySide(30e-6);
    scene.parts[0].contactTolerance = given;
    const std::vector<PartTolerance> found = tolerancesOf(scene);
    EXPECT_EQ(found[0].from, PartTolerance::From::given);
    EXPECT_EQ(found[0].tolerance, given);
    EXPECT_EQ(found[1].from, PartTolerance::From::clearance);
    EXPECT_NEAR(found[1].tolerance, 30e-6 / 8.0, 1e-12);
  }
}

TEST(PartTolerances, PartsThatNeverCollideHaveNoClearance) {
  assets::Scene filtered = sideBySide(30e-6);
  filtered.parts[0].filter.collidesWith = 0;
  expectUsual(filtered);
  assets::Scene joined = sideBySide(30e-6);
  assets::Joint joint;
  joint.partA = 1;
  joint.partB = 0;
  joined.joints.push_back(joint);
  expectUsual(joined);
  joined.joints[0].collide = true;
  EXPECT_EQ(tolerancesOf(joined)[0].from, PartTolerance::From::clearance);
  // Two that nobody can take, beside a third one.
  const assets::Scene fixed =
      sceneOfParts({cube("left", at(0.0), kSide, false), cube("right", at(kSide + 30e-6), kSide, false),
                    cube("held", at(0.0, 1.0))});
  expectUsual(fixed);
}

TEST(PartTolerances, GrowWithTheScene) {
  for (const double scale : {1e-3, 20.0}) {
    const assets::Scene scene = sceneOfParts(
        {cube("left", at(0.0), scale * kSide), cube("right", at(scale * (kSide + 30e-6)), scale * kSide)});
    const std::vector<PartTolerance> found = tolerancesOf(scene);
    EXPECT_EQ(found[0].from, PartTolerance::From::clearance);
    EXPECT_NEAR(found[0].tolerance, scale * 30e-6 / 8.0, scale * 1e-11);
  }
}

TEST(PartTolerances, AreTheSameOnAnyNumberOfThreads) {
  std::vector<CasePart> parts;
  for (int i = 0; i < 12; ++i) parts.push_back(cube("cube", at(i * (kSide + 1e-6 * (10 + i)))));
  for (std::size_t i = 0; i < parts.size(); ++i) parts[i].name += std::to_string(i);
  const assets::Scene scene = sceneOfParts(parts);
  const std::vector<PartTolerance> one = tolerancesOf(scene, 1), three = tolerancesOf(scene, 3);
  for (std::size_t i = 0; i < one.size(); ++i) {
    EXPECT_EQ(one[i].tolerance, three[i].tolerance);
    EXPECT_EQ(one[i].neighbour, three[i].neighbour);
  }
  // The gap to the left is the smaller one: 6 * 16 - 5 * 15 um.
  EXPECT_EQ(one[6].neighbour, 5u);
  EXPECT_NEAR(one[6].tolerance, 21e-6 / 8.0, 1e-12);
}

TEST(PartTolerances, OfPartsThatShareAMeshTheStrictestDecides) {
  assets::Scene scene =
      sceneOfParts({cube("one", at(0.0)), cube("another", at(1.0)), cube("beside", at(kSide + 40e-6))});
  scene.parts[1].mesh = scene.parts[0].mesh;
  ContactScene contact(scene, 1);
  ASSERT_TRUE(contact.modelParts({}));
  const ContactScene::Data& data = contact.data();
  EXPECT_EQ(data.tolerances[1].from, PartTolerance::From::scene);
  ASSERT_EQ(data.colliders[0].model, data.colliders[1].model);
  EXPECT_NEAR(data.colliders[1].model->field.tolerance(), 40e-6 / 8.0, 1e-12);
  EXPECT_LE(data.colliders[1].model->field.worstSmoothError(), 40e-6 / 8.0);
}

TEST(PartTolerances, WhatNoFieldCanHoldIsBounded) {
  EXPECT_EQ(haptics::usableTolerance(1e-9, 1.0), 0x1p-17);
  EXPECT_EQ(haptics::usableTolerance(1e3, 1.0), 0x1p-9);
  EXPECT_EQ(haptics::usableTolerance(1e-4, 1.0), 1e-4);
}

}  // namespace
}  // namespace tandem::test
