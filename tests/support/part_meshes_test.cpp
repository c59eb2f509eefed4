#include "tests/support/part_meshes.h"

#include <gtest/gtest.h>

#include <cmath>

#include <glm/geometric.hpp>

#include "assets/base/constants.h"

namespace tandem::test {
namespace {

/// Area of a regular polygon with its corners at a radius.
double polygonArea(int n, double r) { return 0.5 * n * r * r * std::sin(2.0 * kPi / n); }

/// Volume of the frustum between two such polygons.
double frustum(int n, double r0, double r1, double height) {
  return height / 3.0 * polygonArea(n, 1.0) * (r0 * r0 + r0 * r1 + r1 * r1);
}

/// Welds, expects one clean closed shell, returns the volume.
double solidVolume(const assets::TriangleSoup& soup) {
  const assets::MeshAnalysis found = assets::analyseMesh(soup, 0.5);
  EXPECT_TRUE(found.mesh.closed);
  EXPECT_EQ(found.mesh.shellCount, 1u);
  EXPECT_EQ(found.defects.flippedFaces, 0u);
  EXPECT_EQ(found.defects.invertedShells, 0u);
  EXPECT_EQ(found.defects.boundaryEdges, 0u);
  EXPECT_EQ(found.defects.nonManifoldEdges, 0u);
  EXPECT_EQ(found.defects.duplicateFaces, 0u);
  return found.mesh.volume;
}

TEST(PartMeshes, PegIsTheRevolvedPolygon) {
  const Peg peg{0.01, 0.04, 0.001, {96, 5}};
  const double expected = frustum(96, 0.009, 0.01, 0.001) + 0.039 * polygonArea(96, 0.01);
  EXPECT_NEAR(solidVolume(pegSoup(peg)), expected, 1e-9 * expected);
  const double bare = 0.04 * polygonArea(96, 0.01);
  EXPECT_NEAR(solidVolume(pegSoup({0.01, 0.04, 0.0, {96, 5}})), bare, 1e-9 * bare);
}

TEST(PartMeshes, FacetsGiveTheTrianglesAskedFor) {
  for (const int asked : {5'000, 50'000}) {
    const double made = static_cast<double>(pegSoup({0.01, 0.04, 0.001, facetsFor(asked)}).triangles.size());
    EXPECT_NEAR(made, asked, 0.1 * asked);
  }
  const Facets half = facetsFor(500'000);
  EXPECT_NEAR(2.0 * half.segments * (half.rings + 2), 500'000, 25'000);
}

TEST(PartMeshes, BoreIsAPolygonAroundItsCircle) {
  for (const double depth : {0.03, 0.045}) {
    const BoredBlock block{0.01, depth, 0.06, 0.045, 0.001, Fit::around, {96, 4}};
    const double out = 1.0 / std::cos(kPi / 96);
    const double hole =
        frustum(96, 0.011 * out, 0.01 * out, 0.001) + (depth - 0.001) * polygonArea(96, 0.01 * out);
    const double expected = 0.06 * 0.06 * 0.045 - hole;
    EXPECT_NEAR(solidVolume(boredBlockSoup(block)), expected, 1e-9 * expected) << depth;
  }
}

TEST(PartMeshes, ClearanceBetweenPegAndBoreIsExact) {
  const int n = 96;
  const double clearance = 10e-6;
  const BoredBlock block{0.01 + clearance, 0.03, 0.06, 0.045, 0.0, Fit::around, {n, 2}};
  const assets::TriangleSoup bore = boredBlockSoup(block), peg = pegSoup({0.01, 0.04, 0.001, {n, 3}});
  double farthest = 0.0, nearest = 1.0;
  for (const glm::dvec3& p : peg.positions) farthest = std::max(farthest, glm::length(glm::dvec2(p)));
  // The planes of the wall are seen from the axis at the bore's radius, nowhere less.
  for (const auto& t : bore.triangles) {
    const glm::dvec3 a = bore.positions[t[0]];
    const glm::dvec3 normal = glm::cross(bore.positions[t[1]] - a, bore.positions[t[2]] - a);
    if (std::abs(normal.z) > 1e-9 * glm::length(normal) || glm::length(glm::dvec2(a)) > 0.012) continue;
    nearest = std::min(nearest, std::abs(glm::dot(normal, a)) / glm::length(normal));
  }
  EXPECT_NEAR(nearest - farthest, clearance, 1e-15);
}

TEST(PartMeshes, CoarseBoreAfterCadHasLessRoomByItsSag) {
  EXPECT_NEAR(chordSag(0.01, 40), 31e-6, 0.2e-6);
  EXPECT_EQ(segmentsNeeded(0.01, 10e-6), 100);
  EXPECT_LT(chordSag(0.01, segmentsNeeded(0.01, 10e-6)), 5.1e-6);
  const double inner = 0.01 * (1.0 - std::cos(kPi / 40));
  EXPECT_NEAR(inner, chordSag(0.01, 40), 1e-18);
}

TEST(PartMeshes, BoxBallAndPrismsHaveTheirVolumes) {
  EXPECT_NEAR(solidVolume(boxSoup({0.01, 0.02, 0.03}, 4)), 6e-6, 1e-15);
  EXPECT_EQ(boxSoup({0.01, 0.02, 0.03}, 4).triangles.size(), 12u * 16u);
  const double ball = 4.0 / 3.0 * kPi * 1e-6;
  EXPECT_NEAR(solidVolume(ballSoup(0.01, {96, 48})), ball, 3e-3 * ball);
  EXPECT_NEAR(solidVolume(vGrooveSoup(0.01, kPi / 6, 0.005, 0.03)),
              0.03 * (0.02 * (0.01 + 0.02 * std::tan(kPi / 6)) - 1e-4 * std::tan(kPi / 6)), 1e-14);
  EXPECT_NEAR(solidVolume(slotSoup(0.01, 0.02, 0.005, 0.03)), 0.03 * (0.02 * 0.025 - 0.01 * 0.02), 1e-14);
  EXPECT_NEAR(solidVolume(stairSoup(4, 0.01, 0.005, 0.03)), 0.03 * 0.01 * 0.005 * 10, 1e-14);
}

TEST(PartMeshes, GearFlanksAreInvolutes) {
  const SpurGear gear;
  const double pitch = 0.02, base = pitch * std::cos(gear.pressureAngle);
  // The arc of a tooth at the pitch circle is half the circular pitch, and the involute's angle there is
  // known.
  double tip = 0.0, root = 1.0;
  for (const glm::dvec2& p : spurGearOutline(gear)) {
    tip = std::max(tip, glm::length(p));
    root = std::min(root, glm::length(p));
  }
  EXPECT_NEAR(tip, 0.022, 1e-15);
  EXPECT_NEAR(root, 0.0175, 1e-15);
  const auto involute = [](double a) { return std::tan(a) - a; };
  for (const glm::dvec2& p : spurGearOutline(gear)) {
    const double r = glm::length(p);
    if (r < base || std::atan2(p.y, p.x) < 0.0 || std::atan2(p.y, p.x) > kPi / 20) continue;
    const double expected = kPi / 40 + involute(gear.pressureAngle) - involute(std::acos(base / r));
    EXPECT_NEAR(std::atan2(p.y, p.x), expected, 1e-9) << r;
  }
  const double volume = solidVolume(spurGearSoup(gear));
  EXPECT_GT(volume, 0.01 * kPi * (root * root - 1.6e-5));
  EXPECT_LT(volume, 0.01 * kPi * (tip * tip - 1.6e-5));
}

/// Volume within the true thread: the mean of the squared radius over a pitch, in closed form.
double threadVolume(const Thread& thread, double length) {
  const double r1 = threadProfile(thread, 0.0), r0 = threadProfile(thread, 0.5 * thread.pitch);
  const double flanks = (r1 * r1 + r1 * r0 + r0 * r0) / 3.0;
  return kPi * length * (r1 * r1 / 8.0 + r0 * r0 / 4.0 + flanks * 5.0 / 8.0);
}

TEST(PartMeshes, BoltAndNutHaveTheIsoProfile) {
  const Thread thread{0.008, 0.002, 0.008, 50e-6, 96, 4};
  EXPECT_DOUBLE_EQ(threadProfile(thread, 0.0), 0.008 - 50e-6);
  EXPECT_NEAR(threadProfile(thread, 0.001), 0.008 - 50e-6 - 0.541266 * 0.002, 1e-9);
  const double sag = 1.0 - std::sin(2.0 * kPi / 96) / (2.0 * kPi / 96);  // of the area
  const double bolt = threadVolume(thread, 0.008);
  EXPECT_NEAR(solidVolume(boltThreadSoup(thread)), bolt * (1.0 - sag), 1e-3 * bolt);
  Thread nominal = thread;
  nominal.clearance = 0.0;
  const double outer = 0.008 * polygonArea(96, 0.012), nut = outer - threadVolume(nominal, 0.008);
  EXPECT_NEAR(solidVolume(nutThreadSoup(thread, 0.012)), nut, 3e-3 * nut);
}

TEST(PartMeshes, BoltLiesWithinTheNutByItsClearance) {
  const Thread thread{0.008, 0.002, 0.006, 100e-6, 96, 4};
  // Corners of the nut lie on or outside the nominal thread, those of the bolt inside it by the clearance.
  for (const glm::dvec3& p : boltThreadSoup(thread).positions) {
    const double r = glm::length(glm::dvec2(p)), turn = std::atan2(p.y, p.x) / (2.0 * kPi);
    EXPECT_LE(r, threadProfile(thread, p.z - thread.pitch * turn) + 6e-6);
  }
  Thread nominal = thread;
  nominal.clearance = 0.0;
  for (const glm::dvec3& p : nutThreadSoup(thread, 0.012).positions) {
    const double r = glm::length(glm::dvec2(p)), turn = std::atan2(p.y, p.x) / (2.0 * kPi);
    EXPECT_GE(r, threadProfile(nominal, p.z - thread.pitch * turn) - 6e-6);
  }
}

TEST(PartMeshes, DirtyVersionsAreWhatTheySay) {
  const assets::TriangleSoup box = boxSoup({0.01, 0.01, 0.01}, 2);
  EXPECT_EQ(assets::analyseMesh(insideOut(box), 0.5).defects.invertedShells, 1u);
  EXPECT_TRUE(meshOf(insideOut(box)).closed);  // turned right again
  const assets::MeshAnalysis flipped = assets::analyseMesh(shattered(box, 5), 0.5);
  EXPECT_GT(flipped.defects.flippedFaces, 0u);
  EXPECT_TRUE(flipped.mesh.closed);
  EXPECT_FALSE(meshOf(shattered(box, 0, 7)).closed);
  EXPECT_EQ(rawMeshOf(box).positions.size(), 3 * box.triangles.size());
  EXPECT_EQ(meshOf(joined(box, moved(box, {0.1, 0.0, 0.0}))).shellCount, 2u);
}

}  // namespace
}  // namespace tandem::test
