// Clashes of generated scenes, whose depths and distances are known.

#include "client/review/clash_check.h"

#include <gtest/gtest.h>

#include <string>

#include "haptics/scene/contact_scene.h"
#include "tests/support/bench_meshes.h"
#include "tests/support/part_meshes.h"
#include "tests/support/shapes.h"

namespace tandem::test {
namespace {

using client::Clash;
using client::ClashKind;
using client::ClashOptions;
using client::ClashReport;

/// Cubes of 10 mm along x with these gaps between them (m, negative: overlapping).
assets::Scene rowOfCubes(const std::vector<double>& gaps) {
  assets::Scene scene = tests::sceneOf(boxMesh(glm::dvec3(0.01)));
  for (const double gap : gaps) {
    assets::Part next = scene.parts.back();
    next.name = "cube " + std::to_string(scene.parts.size());
    next.worldFromPart.position.x += 0.01 + gap;
    scene.parts.push_back(next);
  }
  return scene;
}

ClashReport clashesOf(const assets::Scene& scene, double clearance, int threads = 1) {
  ClashOptions options;
  options.clearance = clearance;
  options.threads = threads;
  return client::findClashes(haptics::ContactScene(scene, 1), options);
}

TEST(ClashCheck, ListsOverlapsThenTouchesThenClearances) {
  const assets::Scene scene = rowOfCubes({0.0005, -0.001, 0.0, 0.0002, 0.002, -0.002});
  const ClashReport report = clashesOf(scene, 0.001);
  ASSERT_EQ(report.clashes.size(), 5u);
  const auto expect = [&](std::size_t i, PartId a, ClashKind kind, double depth, double distance) {
    const Clash& clash = report.clashes[i];
    EXPECT_EQ(clash.a, a) << i;
    EXPECT_EQ(clash.b, a + 1) << i;
    EXPECT_EQ(clash.kind, kind) << i;
    EXPECT_NEAR(clash.depth, depth, 1e-15) << i;
    EXPECT_NEAR(clash.distance, distance, 1e-15) << i;
    EXPECT_NEAR(glm::length(clash.onA - clash.onB), depth + distance, 1e-15) << i;
    EXPECT_FALSE(clash.contained || clash.sheets) << i;
  };
  expect(0, 5, ClashKind::hard, 0.002, 0.0);
  expect(1, 1, ClashKind::hard, 0.001, 0.0);
  expect(2, 2, ClashKind::touch, 0.0, 0.0);
  expect(3, 3, ClashKind::clearance, 0.0, 0.0002);
  expect(4, 0, ClashKind::clearance, 0.0, 0.0005);
  EXPECT_EQ(report.pairs, 5u);
  EXPECT_EQ(clashesOf(scene, 0.0).clashes.size(), 3u);
}

TEST(ClashCheck, TakesShallowOverlapsForTouchesIfAskedTo) {
  ClashOptions options;
  options.tolerance = 0.0015;
  const assets::Scene scene = rowOfCubes({-0.001, -0.002});
  const ClashReport report = client::findClashes(haptics::ContactScene(scene, 1), options);
  ASSERT_EQ(report.clashes.size(), 2u);
  EXPECT_EQ(report.clashes[0].a, 1);
  EXPECT_EQ(report.clashes[0].kind, ClashKind::hard);
  EXPECT_EQ(report.clashes[1].kind, ClashKind::touch);
  EXPECT_NEAR(report.clashes[1].depth, 0.001, 1e-15);
}

TEST(ClashCheck, TellsWhatFacetsMayBeOffCurvedSurfaces) {
  // A shaft and a bore of one radius with 48 sides each, rotated so that the corners of one are at the
  // middles of the other's sides.
  test::Peg peg;
  peg.chamfer = 0.0;
  peg.facets = {48, 4};
  test::BoredBlock block;
  block.fit = test::Fit::within;
  block.facets = {48, 4};
  assets::Scene scene = tests::sceneOf(test::meshOf(test::boredBlockSoup(block)));
  scene.meshes.push_back(test::meshOf(test::pegSoup(peg)));
  scene.parts.push_back(scene.parts[0]);
  scene.parts[1].mesh = 1;
  scene.parts[1].worldFromPart = {{0.0, 0.0, -0.03}, fromRotationVector({0.0, 0.0, kPi / 48})};
  const double sag = test::chordSag(0.01, 48);
  ClashReport report = clashesOf(scene, 0.0);
  ASSERT_EQ(report.clashes.size(), 1u);
  EXPECT_NEAR(report.clashes[0].depth, sag, 0.05 * sag);
  EXPECT_NEAR(report.clashes[0].facetSag, 2.0 * sag, 0.05 * sag);
  // A cube in the block's side overlaps by more than facets could explain.
  scene.meshes.push_back(boxMesh(glm::dvec3(0.01)));
  scene.parts[1].mesh = 2;
  scene.parts[1].worldFromPart = {{0.034, 0.0, -0.02}};
  report = clashesOf(scene, 0.0);
  ASSERT_EQ(report.clashes.size(), 1u);
  EXPECT_NEAR(report.clashes[0].depth, 0.001, 1e-15);
  EXPECT_EQ(report.clashes[0].facetSag, 0.0);
}

TEST(ClashCheck, FindsAPartInsideAnother) {
  assets::Scene scene = tests::sceneOf(boxMesh(glm::dvec3(0.06)));
  scene.meshes.push_back(boxMesh(glm::dvec3(0.005)));
  assets::Part inner = scene.parts[0];
  inner.name = "inner";
  inner.mesh = 1;
  scene.parts.push_back(inner);
  const ClashReport report = clashesOf(scene, 0.0);
  ASSERT_EQ(report.clashes.size(), 1u);
  EXPECT_TRUE(report.clashes[0].contained);
  EXPECT_NEAR(report.clashes[0].depth, 0.0275, 1e-15);
}

/// A box without its upper side, from z = 0 to z = -depth.
assets::Mesh openBox(double width, double depth) {
  ShapeBuilder b;
  for (int i = 0; i < 8; ++i)
    b.vertex((i & 1) != 0 ? 0.5 * width : -0.5 * width, (i & 2) != 0 ? 0.5 * width : -0.5 * width,
             (i & 4) != 0 ? 0.0 : -depth);
  b.quad(0, 4, 6, 2);
  b.quad(1, 3, 7, 5);
  b.quad(0, 1, 5, 4);
  b.quad(2, 6, 7, 3);
  b.quad(0, 2, 3, 1);
  return b.mesh();
}

TEST(ClashCheck, SaysThatADepthCannotBeKnownWhereAShellIsOpen) {
  assets::Scene scene = tests::sceneOf(openBox(0.06, 0.06));
  scene.meshes.push_back(boxMesh({0.02, 0.02, 0.03}));
  scene.parts.push_back(scene.parts[0]);
  scene.parts[1].mesh = 1;
  const auto at = [&](const glm::dvec3& place) {
    scene.parts[1].worldFromPart.position = place;
    const ClashReport report = clashesOf(scene, 0.0);
    return report.clashes.empty() ? Clash{} : report.clashes[0];
  };
  // Through a wall, reaching far under the opening: known, since no lid would be nearer than the wall.
  for (const double z : {-0.04, -0.01}) {
    const Clash low = at({0.03, 0.0, z});
    EXPECT_EQ(low.kind, ClashKind::hard);
    EXPECT_FALSE(low.open);
    EXPECT_NEAR(low.depth, 0.01, 1e-9);
  }
  // Through a wall at the opening: 10 mm from the wall, but 4 mm under where a lid would be.
  const Clash high = at({0.03, 0.0, 0.011});
  EXPECT_EQ(high.kind, ClashKind::hard);
  EXPECT_TRUE(high.open);
  EXPECT_LE(high.depth, 0.004 + 1e-9);
  // Dips into the opening and touches nothing.
  EXPECT_NE(at({0.0, 0.0, 0.01}).kind, ClashKind::hard);
}

TEST(ClashCheck, ListsPairsThatMayNotCollideLast) {
  assets::Scene scene = rowOfCubes({-0.002, 0.0, -0.001});
  scene.parts[0].filter = {1, 2};
  assets::Joint hinge;
  hinge.partA = 3;
  hinge.partB = 2;
  scene.joints.push_back(hinge);
  const ClashReport report = clashesOf(scene, 0.0);
  ASSERT_EQ(report.clashes.size(), 3u);
  EXPECT_EQ(report.clashes[0].kind, ClashKind::touch);
  EXPECT_TRUE(report.clashes[0].mayCollide);
  EXPECT_EQ(report.clashes[1].a, 0);
  EXPECT_FALSE(report.clashes[1].mayCollide);
  EXPECT_EQ(report.clashes[2].a, 2);
  EXPECT_FALSE(report.clashes[2].mayCollide);
  scene.joints[0].collide = true;
  EXPECT_EQ(clashesOf(scene, 0.0).clashes[0].kind, ClashKind::hard);
}

TEST(ClashCheck, DoesNotDependOnTheNumberOfThreadsAndTellsItsProgress) {
  const assets::Scene scene = rowOfCubes(std::vector<double>(9, -0.0001));
  const ClashReport one = clashesOf(scene, 0.02, 1);
  std::size_t done = 0, pairs = 0;
  ClashOptions options;
  options.clearance = 0.02;
  options.threads = 3;
  options.progress = [&](std::size_t d, std::size_t p) {
    EXPECT_GE(d, done);
    done = d;
    pairs = p;
  };
  const ClashReport three = client::findClashes(haptics::ContactScene(scene, 1), options);
  ASSERT_EQ(one.clashes.size(), three.clashes.size());
  for (std::size_t i = 0; i < one.clashes.size(); ++i) {
    EXPECT_EQ(one.clashes[i].a, three.clashes[i].a);
    EXPECT_EQ(one.clashes[i].b, three.clashes[i].b);
    EXPECT_EQ(one.clashes[i].depth, three.clashes[i].depth);
    EXPECT_EQ(one.clashes[i].onA, three.clashes[i].onA);
  }
  EXPECT_TRUE(done == 0 || pairs == one.pairs);
}

TEST(ClashCheck, MeasuresTwoPartsHoweverFarApart) {
  const assets::Scene scene = rowOfCubes({0.5, 1.0});
  const haptics::ContactScene contact(scene, 1);
  const auto at = [&](PartId part) { return scene.parts[part].worldFromPart; };
  const auto far = client::measurePair(client::PartClosings(contact), 2, at(2), 0, at(0));
  ASSERT_TRUE(far.has_value());
  EXPECT_EQ(far->a, 2);
  EXPECT_EQ(far->kind, ClashKind::clearance);
  EXPECT_NEAR(far->distance, 1.51, 1e-14);
  EXPECT_NEAR(far->onA.x, 1.515, 1e-14);
}

TEST(ClashCheck, NamesTheNearestNeighbourOfAPart) {
  assets::Scene scene = rowOfCubes({0.004, 0.003, 0.0, -0.001});
  const auto nearest = [&](PartId part) {
    std::vector<Pose> poses;
    for (const assets::Part& p : scene.parts) poses.push_back(p.worldFromPart);
    const haptics::ContactScene contact(scene, 1);
    return client::nearestPart(client::PartClosings(contact), part, poses);
  };
  EXPECT_EQ(nearest(0)->b, 1);
  EXPECT_NEAR(nearest(0)->distance, 0.004, 1e-15);
  EXPECT_EQ(nearest(1)->b, 2);
  EXPECT_NEAR(nearest(1)->distance, 0.003, 1e-15);
  EXPECT_NEAR(glm::length(nearest(1)->onA - nearest(1)->onB), 0.003, 1e-15);
  EXPECT_EQ(nearest(2)->kind, ClashKind::touch);
  EXPECT_EQ(nearest(4)->kind, ClashKind::hard);
  EXPECT_NEAR(nearest(4)->depth, 0.001, 1e-15);
  scene.parts[2].filter = {0, 0};
  EXPECT_EQ(nearest(1)->b, 0) << "the nearer one may not collide";
  scene.meshes.push_back(boxMesh(glm::dvec3(0.002)));
  scene.parts[0].mesh = 1;
  scene.parts[0].worldFromPart = scene.parts[1].worldFromPart;
  EXPECT_TRUE(nearest(0)->contained);
  EXPECT_TRUE(nearest(1)->contained);
  scene.parts.resize(1);
  EXPECT_FALSE(nearest(0).has_value());
}

TEST(ClashCheck, HasNothingToSayOfPartsWithoutGeometry) {
  assets::Scene scene = rowOfCubes({-0.001});
  scene.parts[1].mesh = assets::kNone;
  EXPECT_TRUE(clashesOf(scene, 1.0).clashes.empty());
  const haptics::ContactScene contact(scene, 1);
  EXPECT_FALSE(client::measurePair(client::PartClosings(contact), 0, {}, 1, {}).has_value());
}

}  // namespace
}  // namespace tandem::test
