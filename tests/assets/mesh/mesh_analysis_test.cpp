#include "assets/mesh/mesh_analysis.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <set>

#include <gtest/gtest.h>

#include "tests/assets/mesh/soups.h"

namespace tandem::assets {
namespace {

using test::addBox;
using test::addQuad;
using test::addTriangle;
using test::box;
using test::flip;
using test::flipAll;
using test::ribbon;
using test::scaled;
using test::sphere;

using Triangle = std::array<std::uint32_t, 3>;

constexpr double kCrease = 0.5235987755982988;

MeshAnalysis analyse(const TriangleSoup& soup) { return analyseMesh(soup, kCrease); }

/// What must hold for every result, whatever the input was.
void expectConsistent(const Mesh& mesh) {
  const std::size_t count = mesh.triangles.size();
  ASSERT_EQ(mesh.triangleMaterial.size(), count);
  ASSERT_EQ(mesh.neighbours.size(), count);
  ASSERT_EQ(mesh.edgeFlags.size(), count);
  ASSERT_EQ(mesh.triangleShell.size(), count);
  std::set<std::uint32_t> shells, used;
  for (std::size_t t = 0; t < count; ++t) {
    shells.insert(mesh.triangleShell[t]);
    used.insert(mesh.triangles[t].begin(), mesh.triangles[t].end());
    for (int e = 0; e < 3; ++e) {
      ASSERT_LT(mesh.triangles[t][e], mesh.positions.size());
      const std::uint32_t a = mesh.triangles[t][e], b = mesh.triangles[t][(e + 1) % 3];
      ASSERT_NE(a, b);
      const std::uint32_t other = mesh.neighbours[t][e];
      const bool alone = mesh.edgeFlags[t][e] & (kEdgeBoundary | kEdgeNonManifold);
      ASSERT_EQ(other == kNone, alone);
      if (alone) continue;
      ASSERT_EQ(mesh.triangleShell[other], mesh.triangleShell[t]);
      int back = -1;
      for (int k = 0; k < 3; ++k) {
        const std::uint32_t c = mesh.triangles[other][k], d = mesh.triangles[other][(k + 1) % 3];
        if ((c == a && d == b) || (c == b && d == a)) back = k;
      }
      ASSERT_GE(back, 0) << "the neighbour does not have this edge";
      ASSERT_EQ(mesh.neighbours[other][back], t);
      ASSERT_EQ(mesh.edgeFlags[other][back], mesh.edgeFlags[t][e]);
    }
  }
  EXPECT_EQ(shells.size(), mesh.shellCount);
  EXPECT_EQ(used.size(), mesh.positions.size());
}

void expectNoDefects(const MeshDefects& d) {
  EXPECT_EQ(d.degenerateFaces, 0u);
  EXPECT_EQ(d.duplicateFaces, 0u);
  EXPECT_EQ(d.flippedFaces, 0u);
  EXPECT_EQ(d.invertedShells, 0u);
  EXPECT_EQ(d.openShells, 0u);
  EXPECT_EQ(d.boundaryEdges, 0u);
  EXPECT_EQ(d.nonManifoldEdges, 0u);
  EXPECT_EQ(d.nonOrientableShells, 0u);
}

void expectSameTopology(const MeshAnalysis& a, const MeshAnalysis& b) {
  EXPECT_EQ(a.mesh.triangles, b.mesh.triangles);
  EXPECT_EQ(a.mesh.neighbours, b.mesh.neighbours);
  EXPECT_EQ(a.mesh.edgeFlags, b.mesh.edgeFlags);
  EXPECT_EQ(a.mesh.triangleShell, b.mesh.triangleShell);
  EXPECT_EQ(a.mesh.closed, b.mesh.closed);
}

TEST(MeshAnalysis, WeldsABoxWhoseFacesHaveTheirOwnCorners) {
  const MeshAnalysis a = analyse(box(glm::dvec3(0.0), glm::dvec3(1.0, 2.0, 3.0)));
  expectConsistent(a.mesh);
  expectNoDefects(a.defects);
  EXPECT_EQ(a.mesh.positions.size(), 8u);
  EXPECT_EQ(a.mesh.triangles.size(), 12u);
  EXPECT_EQ(a.defects.duplicateVertices, 28u);
  EXPECT_EQ(a.defects.sharpEdges, 12u);
  EXPECT_EQ(a.mesh.shellCount, 1u);
  EXPECT_TRUE(a.mesh.closed);
  EXPECT_NEAR(a.mesh.volume, 6.0, 1e-14);
  EXPECT_EQ(a.mesh.bounds.max, glm::dvec3(1.0, 2.0, 3.0));
}

TEST(MeshAnalysis, SharpEdgesAreThoseAboveTheCreaseAngle) {
  const TriangleSoup prism = sphere(1.0, 4);  // every edge bends by about 45 degrees
  EXPECT_EQ(analyseMesh(prism, 1.5).defects.sharpEdges, 0u);
  EXPECT_GT(analyseMesh(prism, 0.5).defects.sharpEdges, 30u);
}

TEST(MeshAnalysis, TopologyIsTheSameAtEveryScale) {
  TriangleSoup soup = sphere(0.7, 12);
  addBox(soup, glm::dvec3(1.0, 0.0, 0.0), glm::dvec3(1.5, 0.1, 0.1));
  addBox(soup, glm::dvec3(1.5, 0.1, 0.0), glm::dvec3(1.7, 0.2, 0.1));
  for (std::size_t t = 0; t < soup.triangles.size(); t += 7) flip(soup, t);
  // Points that differ in the last float digits must be welded alike too.
  std::mt19937 engine(3);
  for (glm::dvec3& p : soup.positions) p.x += 1e-8 * static_cast<double>(engine() % 9);
  const MeshAnalysis once = analyse(soup);
  expectConsistent(once.mesh);
  EXPECT_EQ(once.defects.boundaryEdges, 0u);
  for (const double scale : {1e-12, 1e-3, 0.0254, 20.0, 1e9})
    expectSameTopology(once, analyse(scaled(soup, scale)));
}

TEST(MeshAnalysis, JoinsVerticesWithinFloatPrecisionAndNoFurther) {
  const auto pairAt = [](double gap) {
    TriangleSoup soup;
    addTriangle(soup, glm::dvec3(0.0), glm::dvec3(1.0, 0.0, 0.0), glm::dvec3(0.0, 1.0, 0.0));
    addTriangle(soup, glm::dvec3(gap, 0.0, 0.0), glm::dvec3(0.0, 1.0, 0.0), glm::dvec3(-1.0, 0.0, 0.0));
    return analyse(soup).mesh.positions.size();
  };
  EXPECT_EQ(pairAt(0.0), 4u);
  EXPECT_EQ(pairAt(1e-7), 4u);
  EXPECT_EQ(pairAt(1e-6), 5u);
}

TEST(MeshAnalysis, WeldingDoesNotDependOnWhereAPointLiesInTheGrid) {
  std::mt19937_64 engine(11);
  std::uniform_real_distribution<double> place(-1.0, 1.0);
  for (int i = 0; i < 2000; ++i) {
    const glm::dvec3 p(place(engine), place(engine), place(engine));
    const glm::dvec3 nudge = 2.3e-7 * glm::dvec3(place(engine), place(engine), place(engine));
    TriangleSoup soup;
    addTriangle(soup, glm::dvec3(1.0), glm::dvec3(-1.0, 1.0, 1.0), p);
    addTriangle(soup, glm::dvec3(-1.0, 1.0, 1.0), glm::dvec3(1.0), p + nudge);
    ASSERT_EQ(analyse(soup).mesh.positions.size(), 3u);
  }
}

TEST(MeshAnalysis, DropsAFifthOfZeroAreaFacesAndKeepsTheRestClosed) {
  TriangleSoup soup = sphere(1.0, 16);
  const std::size_t good = soup.triangles.size();
  for (std::size_t t = 0; t < good; t += 4) {
    const auto corners = soup.triangles[t];
    soup.triangles.push_back({corners[0], corners[0], corners[1]});
    soup.triangleMaterial.push_back(0);
  }
  const MeshAnalysis a = analyse(soup);
  expectConsistent(a.mesh);
  EXPECT_EQ(a.defects.degenerateFaces, soup.triangles.size() - good);
  EXPECT_EQ(a.mesh.triangles.size(), good);
  EXPECT_TRUE(a.mesh.closed);
}

TEST(MeshAnalysis, DropsFacesWithThreePointsOnALine) {
  TriangleSoup soup = box(glm::dvec3(0.0), glm::dvec3(1.0));
  addTriangle(soup, glm::dvec3(3.0, 0.0, 0.0), glm::dvec3(3.5, 0.1, 0.0), glm::dvec3(4.0, 0.2, 0.0));
  const MeshAnalysis a = analyse(soup);
  EXPECT_EQ(a.defects.degenerateFaces, 1u);
  EXPECT_EQ(a.defects.unusedVertices, 3u);
  EXPECT_TRUE(a.mesh.closed);
  EXPECT_EQ(a.mesh.bounds.max.x, 1.0);
}

TEST(MeshAnalysis, KeepsSliversOfTenThousandToOne) {
  const MeshAnalysis a = analyse(box(glm::dvec3(0.0), glm::dvec3(1.0, 1e-4, 1e-4)));
  expectNoDefects(a.defects);
  EXPECT_EQ(a.mesh.triangles.size(), 12u);
  EXPECT_EQ(a.defects.sharpEdges, 12u);
  EXPECT_NEAR(a.mesh.volume, 1e-8, 1e-20);
}

TEST(MeshAnalysis, DropsDuplicatesInEitherOrientationAndKeepsTheFirst) {
  TriangleSoup soup = box(glm::dvec3(0.0), glm::dvec3(1.0));
  soup.triangleMaterial.assign(12, 3);
  for (std::size_t t = 0; t < 6; ++t) {
    const auto c = soup.triangles[t];
    soup.triangles.push_back(t % 2 ? Triangle{c[1], c[2], c[0]} : Triangle{c[2], c[1], c[0]});
    soup.triangleMaterial.push_back(9);
  }
  const MeshAnalysis a = analyse(soup);
  expectConsistent(a.mesh);
  EXPECT_EQ(a.defects.duplicateFaces, 6u);
  EXPECT_EQ(a.defects.flippedFaces, 0u);
  EXPECT_TRUE(a.mesh.closed);
  EXPECT_EQ(std::count(a.mesh.triangleMaterial.begin(), a.mesh.triangleMaterial.end(), 3), 12);
}

TEST(MeshAnalysis, TurnsTheMinorityOfFacesAndRestoresTheVolume) {
  const double volume = analyse(sphere(1.0, 10)).mesh.volume;
  TriangleSoup soup = sphere(1.0, 10);
  for (std::size_t t = 0; t < soup.triangles.size(); t += 3) flip(soup, t);
  const MeshAnalysis a = analyse(soup);
  expectConsistent(a.mesh);
  EXPECT_EQ(a.defects.flippedFaces, (soup.triangles.size() + 2) / 3);
  EXPECT_EQ(a.defects.invertedShells, 0u);
  EXPECT_TRUE(a.mesh.closed);
  EXPECT_NEAR(a.mesh.volume, volume, 1e-12);
}

TEST(MeshAnalysis, TurnsAnInsideOutShellOutward) {
  TriangleSoup soup = sphere(1.0, 10);
  flipAll(soup);
  const MeshAnalysis a = analyse(soup), upright = analyse(sphere(1.0, 10));
  expectConsistent(a.mesh);
  EXPECT_EQ(a.defects.invertedShells, 1u);
  EXPECT_EQ(a.defects.flippedFaces, 0u);
  EXPECT_NEAR(a.mesh.volume, upright.mesh.volume, 1e-12);
  EXPECT_EQ(a.defects.sharpEdges, upright.defects.sharpEdges);
}

TEST(MeshAnalysis, ATJunctionIsWeldedIntoItsEdge) {
  TriangleSoup soup;
  addTriangle(soup, glm::dvec3(0.0), glm::dvec3(1.0, 0.0, 0.0), glm::dvec3(0.5, 1.0, 0.0));
  addTriangle(soup, glm::dvec3(0.5, 0.0, 0.0), glm::dvec3(0.0), glm::dvec3(0.25, -1.0, 0.0));
  addTriangle(soup, glm::dvec3(1.0, 0.0, 0.0), glm::dvec3(0.5, 0.0, 0.0), glm::dvec3(0.75, -1.0, 0.0));
  const MeshAnalysis a = analyse(soup);
  expectConsistent(a.mesh);
  EXPECT_EQ(a.defects.tJunctions, 1u);
  EXPECT_EQ(a.mesh.triangles.size(), 4u);
  EXPECT_EQ(a.defects.boundaryEdges, 6u);
  EXPECT_EQ(a.defects.openShells, 1u);
  EXPECT_FALSE(a.mesh.closed);
}

TEST(MeshAnalysis, AMoebiusStripIsCountedAndLosesNothing) {
  const MeshAnalysis moebius = analyse(ribbon(24, 1)), twisted = analyse(ribbon(24, 2));
  expectConsistent(moebius.mesh);
  EXPECT_EQ(moebius.mesh.triangles.size(), 48u);
  EXPECT_EQ(moebius.defects.nonOrientableShells, 1u);
  EXPECT_EQ(moebius.defects.boundaryEdges, 48u);
  EXPECT_EQ(moebius.mesh.shellCount, 1u);
  EXPECT_EQ(twisted.defects.nonOrientableShells, 0u);
  EXPECT_EQ(twisted.mesh.shellCount, 1u);
}

TEST(MeshAnalysis, TwoBoxesThatShareAnEdgeStayTwoSolids) {
  TriangleSoup soup = box(glm::dvec3(0.0), glm::dvec3(1.0));
  addBox(soup, glm::dvec3(1.0, 1.0, 0.0), glm::dvec3(2.0, 2.0, 1.0));
  flipAll(soup, 12);  // the second one inside out
  const MeshAnalysis a = analyse(soup);
  expectConsistent(a.mesh);
  EXPECT_EQ(a.mesh.triangles.size(), 24u);
  EXPECT_EQ(a.mesh.positions.size(), 14u);
  EXPECT_EQ(a.defects.nonManifoldEdges, 1u);
  EXPECT_EQ(a.defects.boundaryEdges, 0u);
  EXPECT_EQ(a.defects.openShells, 0u);
  EXPECT_EQ(a.defects.invertedShells, 1u);
  EXPECT_EQ(a.mesh.shellCount, 2u);
  EXPECT_FALSE(a.mesh.closed);
  EXPECT_NEAR(massProperties(a.mesh, 1000.0).mass, 2000.0, 1e-9);
}

TEST(MeshAnalysis, TwoBoxesThatShareACornerAreClosed) {
  TriangleSoup soup = box(glm::dvec3(0.0), glm::dvec3(1.0));
  addBox(soup, glm::dvec3(1.0), glm::dvec3(2.0));
  const MeshAnalysis a = analyse(soup);
  expectConsistent(a.mesh);
  expectNoDefects(a.defects);
  EXPECT_EQ(a.mesh.positions.size(), 15u);
  EXPECT_EQ(a.mesh.shellCount, 2u);
  EXPECT_TRUE(a.mesh.closed);
  EXPECT_NEAR(a.mesh.volume, 2.0, 1e-14);
}

TEST(MeshAnalysis, ThreeFacesAtAnEdgeAreAllKept) {
  TriangleSoup soup;
  for (int i = 0; i < 3; ++i)
    addTriangle(soup, glm::dvec3(0.0), glm::dvec3(0.0, 0.0, 1.0),
                glm::dvec3(std::cos(2.0 * i), std::sin(2.0 * i), 0.5));
  const MeshAnalysis a = analyse(soup);
  expectConsistent(a.mesh);
  EXPECT_EQ(a.mesh.triangles.size(), 3u);
  EXPECT_EQ(a.mesh.positions.size(), 5u);
  EXPECT_EQ(a.defects.nonManifoldEdges, 1u);
  EXPECT_EQ(a.defects.boundaryEdges, 6u);
  EXPECT_EQ(a.mesh.shellCount, 3u);
}

TEST(MeshAnalysis, ACavityStaysACavity) {
  TriangleSoup soup = box(glm::dvec3(0.0), glm::dvec3(4.0));
  addBox(soup, glm::dvec3(1.0), glm::dvec3(3.0));
  flipAll(soup, 12);
  const MeshAnalysis a = analyse(soup);
  expectConsistent(a.mesh);
  expectNoDefects(a.defects);
  EXPECT_NEAR(a.mesh.volume, 64.0 - 8.0, 1e-12);
}

TEST(MeshAnalysis, ACavityInAnInsideOutSolidIsTurnedWithIt) {
  TriangleSoup soup = box(glm::dvec3(0.0), glm::dvec3(4.0));
  flipAll(soup);
  addBox(soup, glm::dvec3(1.0), glm::dvec3(3.0));
  const MeshAnalysis a = analyse(soup);
  EXPECT_EQ(a.defects.invertedShells, 2u);
  EXPECT_NEAR(a.mesh.volume, 64.0 - 8.0, 1e-12);
}

TEST(MeshAnalysis, ASolidWithinACavityCountsAndASolidWithinASolidIsNotTurned) {
  TriangleSoup soup = box(glm::dvec3(0.0), glm::dvec3(8.0));
  addBox(soup, glm::dvec3(1.0), glm::dvec3(7.0));
  flipAll(soup, 12);
  addBox(soup, glm::dvec3(2.0), glm::dvec3(6.0));
  const MeshAnalysis a = analyse(soup);
  expectNoDefects(a.defects);
  EXPECT_NEAR(a.mesh.volume, 512.0 - 216.0 + 64.0, 1e-10);

  TriangleSoup within = box(glm::dvec3(0.0), glm::dvec3(4.0));
  addBox(within, glm::dvec3(1.0), glm::dvec3(3.0));
  EXPECT_EQ(analyse(within).defects.invertedShells, 0u);
  EXPECT_NEAR(analyse(within).mesh.volume, 72.0, 1e-12);
}

TEST(MeshAnalysis, ShellsSideBySideAreTurnedOneByOne) {
  TriangleSoup soup;
  for (int i = 0; i < 20; ++i) {
    const std::size_t first = soup.triangles.size();
    addBox(soup, glm::dvec3(2.0 * i, 0.0, 0.0), glm::dvec3(2.0 * i + 1.0, 1.0, 1.0));
    if (i % 3 == 0) flipAll(soup, first);
  }
  const MeshAnalysis a = analyse(soup);
  EXPECT_EQ(a.defects.invertedShells, 7u);
  EXPECT_EQ(a.mesh.shellCount, 20u);
  EXPECT_NEAR(a.mesh.volume, 20.0, 1e-12);
}

TEST(MeshAnalysis, ThousandsOfInvertedShellsOverEachOtherStayWithinBoundedWork) {
  // Every face spans the whole mesh; with a column for each place this would fill the memory.
  TriangleSoup soup;
  for (int i = 0; i < 3000; ++i) addBox(soup, glm::dvec3(-1.0 - 1e-4 * i), glm::dvec3(1.0 + 1e-4 * i));
  flipAll(soup);
  const MeshAnalysis a = analyse(soup);
  expectConsistent(a.mesh);
  EXPECT_EQ(a.mesh.shellCount, 3000u);
  EXPECT_EQ(a.defects.invertedShells, 3000u);
}

TEST(MeshAnalysis, NothingAndOneTriangle) {
  const MeshAnalysis nothing = analyse(TriangleSoup{});
  EXPECT_EQ(nothing.mesh.shellCount, 0u);
  EXPECT_FALSE(nothing.mesh.closed);
  EXPECT_EQ(massProperties(nothing.mesh, 1000.0).mass, 0.0);

  TriangleSoup soup;
  addTriangle(soup, glm::dvec3(0.0), glm::dvec3(1.0, 0.0, 0.0), glm::dvec3(0.0, 1.0, 0.0));
  const MeshAnalysis one = analyse(soup);
  expectConsistent(one.mesh);
  EXPECT_EQ(one.defects.boundaryEdges, 3u);
  EXPECT_EQ(one.defects.openShells, 1u);
  EXPECT_EQ(one.mesh.shellCount, 1u);
}

TEST(MeshAnalysis, FacesInOnePointLeaveAnEmptyMesh) {
  TriangleSoup soup;
  addTriangle(soup, glm::dvec3(0.0), glm::dvec3(0.0), glm::dvec3(0.0));
  addTriangle(soup, glm::dvec3(0.0), glm::dvec3(0.0), glm::dvec3(0.0));
  const MeshAnalysis a = analyse(soup);
  EXPECT_TRUE(a.mesh.triangles.empty());
  EXPECT_TRUE(a.mesh.positions.empty());
  EXPECT_EQ(a.defects.degenerateFaces, 2u);
}

TEST(MeshAnalysis, AFarStrayVertexThatNoFaceUsesDoesNotCoarsenTheWelding) {
  TriangleSoup soup = box(glm::dvec3(0.0), glm::dvec3(1e-3));
  soup.positions.push_back(glm::dvec3(1e9));
  const MeshAnalysis a = analyse(soup);
  EXPECT_TRUE(a.mesh.closed);
  EXPECT_EQ(a.defects.unusedVertices, 1u);
}

TEST(MeshAnalysis, RandomSoupsStayConsistentAndLoseOnlyWhatIsCounted) {
  std::mt19937 engine(5);
  std::uniform_int_distribution<std::uint32_t> corner(0, 11);
  for (int round = 0; round < 200; ++round) {
    TriangleSoup soup;
    for (int v = 0; v < 12; ++v)
      soup.positions.push_back(glm::dvec3(engine() % 3, engine() % 3, engine() % 3));
    for (int t = 0; t < 40; ++t) {
      soup.triangles.push_back({corner(engine), corner(engine), corner(engine)});
      soup.triangleMaterial.push_back(0);
    }
    const MeshAnalysis a = analyse(soup);
    expectConsistent(a.mesh);
    EXPECT_EQ(a.mesh.triangles.size() + a.defects.degenerateFaces + a.defects.duplicateFaces,
              40u + a.defects.tJunctions);
  }
}

TEST(MassProperties, OfABoxAreExactWhereverItStands) {
  const glm::dvec3 size(0.1, 0.2, 0.4), low(10.0, -3.0, 7.0);
  const MassProperties m = massProperties(analyse(box(low, low + size)).mesh, 7850.0);
  const double mass = 7850.0 * 0.1 * 0.2 * 0.4;
  EXPECT_NEAR(m.mass, mass, 1e-12 * mass);
  EXPECT_LT(glm::length(m.centreOfMass - (low + 0.5 * size)), 1e-14);
  EXPECT_NEAR(m.inertia[0][0], mass / 12.0 * (0.04 + 0.16), 1e-12);
  EXPECT_NEAR(m.inertia[1][1], mass / 12.0 * (0.16 + 0.01), 1e-12);
  EXPECT_NEAR(m.inertia[2][2], mass / 12.0 * (0.01 + 0.04), 1e-12);
  EXPECT_NEAR(m.inertia[0][1], 0.0, 1e-12);
}

TEST(MassProperties, OfAnLOfTwoBoxesFollowTheParallelAxisTheorem) {
  TriangleSoup soup = box(glm::dvec3(0.0), glm::dvec3(1.0));
  addBox(soup, glm::dvec3(2.0, 0.0, 0.0), glm::dvec3(3.0, 1.0, 1.0));
  const MassProperties m = massProperties(analyse(soup).mesh, 6.0);
  EXPECT_NEAR(m.mass, 12.0, 1e-12);
  EXPECT_LT(glm::length(m.centreOfMass - glm::dvec3(1.5, 0.5, 0.5)), 1e-14);
  EXPECT_NEAR(m.inertia[0][0], 2.0, 1e-12);
  EXPECT_NEAR(m.inertia[1][1], 2.0 + 12.0, 1e-12);
}

TEST(MassProperties, OfASphereConvergeWithTheTessellation) {
  const double mass = 4.0 / 3.0 * M_PI * 1000.0 * 0.125;
  double previous = 1.0;
  for (const int rings : {8, 16, 32, 64}) {
    const MassProperties m = massProperties(analyse(sphere(0.5, rings)).mesh, 1000.0);
    const double error = std::abs(m.mass - mass) / mass;
    EXPECT_LT(error, 0.3 * previous);  // second order
    EXPECT_NEAR(m.inertia[2][2], 0.4 * mass * 0.25, 3.0 * error * m.inertia[2][2]);
    previous = error;
  }
  EXPECT_LT(previous, 2e-3);
}

TEST(MassProperties, OfOpenMeshesArePositiveDefinite) {
  TriangleSoup plate, needle, cup = box(glm::dvec3(0.0), glm::dvec3(1.0));
  addQuad(plate, glm::dvec3(0.0), glm::dvec3(1.0, 0.0, 0.0), glm::dvec3(1.0, 1.0, 0.0),
          glm::dvec3(0.0, 1.0, 0.0));
  addTriangle(needle, glm::dvec3(0.0), glm::dvec3(1.0, 0.0, 0.0), glm::dvec3(0.5, 1e-5, 0.0));
  cup.triangles.resize(10);
  cup.triangleMaterial.resize(10);
  for (const TriangleSoup& soup : {plate, needle, cup, ribbon(30, 1)}) {
    for (const double scale : {1e-3, 1.0, 20.0}) {
      const MassProperties m = massProperties(analyse(scaled(soup, scale)).mesh, 2700.0);
      EXPECT_GT(m.mass, 0.0);
      EXPECT_GT(m.inertia[0][0], 0.0);
      EXPECT_GT(m.inertia[0][0] * m.inertia[1][1] - m.inertia[0][1] * m.inertia[1][0], 0.0);
      EXPECT_GT(glm::determinant(m.inertia), 0.0);
      EXPECT_GT(m.inertia[0][0] + m.inertia[1][1], m.inertia[2][2]);  // no rigid body breaks this
    }
  }
  const double share = massProperties(analyse(cup).mesh, 1.0).mass;
  EXPECT_GT(share, 0.25);
  EXPECT_LE(share, 1.0);
}

}  // namespace
}  // namespace tandem::assets
