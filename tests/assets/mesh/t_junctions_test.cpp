// Vertices on edges are welded into them, on generated meshes of many kinds at three scales; what only looks
// like it stays as it is. The audit of the results is a brute force of its own.

#include "assets/mesh/t_junctions.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <string>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "assets/mesh/mesh_analysis.h"
#include "assets/mesh/vertex_weld.h"
#include "tests/assets/gltf/load_for_test.h"
#include "tests/support/part_meshes.h"
#include "tests/support/t_junction_meshes.h"

namespace tandem::assets {
namespace {

using tandem::test::EdgeCuts;
using tandem::test::placed;
using tandem::test::roundedToFloat;
using tandem::test::turnOf;
using tandem::test::withTJunctions;

constexpr double kCreaseAngle = 0.5235987755982988;
constexpr double kScales[] = {1e-3, 1.0, 1e3};

double sizeOf(const TriangleSoup& soup) {
  double size = 0.0;
  for (const glm::dvec3& p : soup.positions)
    size = std::max({size, std::abs(p.x), std::abs(p.y), std::abs(p.z)});
  return size;
}

/// Half a unit in the last place of the largest coordinate as a float, m.
double roundingOf(const TriangleSoup& soup) { return std::ldexp(sizeOf(soup), -24); }

/// Edges by the number of their faces, and open edges that lie on others.
struct Audit {
  std::size_t open = 0, many = 0, overlapping = 0;
  double area = 0.0, volume = 0.0;  // m^2, m^3
};

double distanceToSegment(const glm::dvec3& p, const glm::dvec3& a, const glm::dvec3& b) {
  const double t = std::clamp(glm::dot(p - a, b - a) / glm::dot(b - a, b - a), 0.0, 1.0);
  return glm::distance(p, a + t * (b - a));
}

/// Whether two segments have more in common than an end: two different ends that lie on both.
bool runAlong(const std::array<glm::dvec3, 2>& s, const std::array<glm::dvec3, 2>& t, double near) {
  std::vector<glm::dvec3> common;
  for (const glm::dvec3& p : s)
    if (distanceToSegment(p, t[0], t[1]) <= near) common.push_back(p);
  for (const glm::dvec3& p : t)
    if (distanceToSegment(p, s[0], s[1]) <= near) common.push_back(p);
  for (const glm::dvec3& p : common)
    if (glm::distance(p, common.front()) > 4.0 * near) return true;
  return false;
}

Audit audit(const std::vector<glm::dvec3>& positions, const std::vector<TriangleIndices>& triangles,
            double near) {
  Audit result;
  std::map<std::array<std::uint32_t, 2>, int> faces;
  for (const TriangleIndices& t : triangles) {
    const glm::dvec3 &a = positions[t[0]], &b = positions[t[1]], &c = positions[t[2]];
    result.area += 0.5 * glm::length(glm::cross(b - a, c - a));
    result.volume += glm::dot(a, glm::cross(b, c)) / 6.0;
    for (int e = 0; e < 3; ++e) ++faces[{std::min(t[e], t[(e + 1) % 3]), std::max(t[e], t[(e + 1) % 3])}];
  }
  std::vector<std::array<glm::dvec3, 2>> open;
  for (const auto& [ends, count] : faces) {
    if (count == 1) open.push_back({positions[ends[0]], positions[ends[1]]});
    result.many += count > 2 ? 1 : 0;
  }
  result.open = open.size();
  // Where many overlap, one is enough to know.
  for (std::size_t i = 0; i < open.size() && result.overlapping == 0; ++i)
    for (std::size_t j = 0; j < i; ++j) result.overlapping += runAlong(open[i], open[j], near) ? 1 : 0;
  return result;
}

Audit auditOf(const Mesh& mesh, double near) { return audit(mesh.positions, mesh.triangles, near); }

double distanceToTriangle(const glm::dvec3& p, const std::array<glm::dvec3, 3>& t) {
  const glm::dvec3 normal = glm::cross(t[1] - t[0], t[2] - t[0]);
  bool over = true;
  double least = 1e300;
  for (int e = 0; e < 3; ++e) {
    const glm::dvec3 &a = t[e], &b = t[(e + 1) % 3];
    over = over && glm::dot(glm::cross(normal, b - a), p - a) >= 0.0;
    least = std::min(least, distanceToSegment(p, a, b));
  }
  return over ? std::abs(glm::dot(normal, p - t[0])) / glm::length(normal) : least;
}

/// m, how far places on some forty triangles of one mesh are from those of another at most.
double departure(const Mesh& of, const TriangleSoup& from) {
  double most = 0.0;
  for (std::size_t i = 0; i < of.triangles.size(); i += 1 + of.triangles.size() / 40) {
    const TriangleIndices& t = of.triangles[i];
    for (const glm::dvec3& w : {glm::dvec3(0.5, 0.5, 0), glm::dvec3(0.3, 0.3, 0.4)}) {
      const glm::dvec3 p = w.x * of.positions[t[0]] + w.y * of.positions[t[1]] + w.z * of.positions[t[2]];
      double least = 1e300;
      for (const TriangleIndices& s : from.triangles)
        least = std::min(
            least, distanceToTriangle(p, {from.positions[s[0]], from.positions[s[1]], from.positions[s[2]]}));
      most = std::max(most, least);
    }
  }
  return most;
}

/// The topology without the weld of junctions: the negative control of what follows.
Audit withoutWeld(const TriangleSoup& soup, double near) {
  const WeldedVertices welded = weldVertices(soup.positions, soup.triangles);
  std::vector<TriangleIndices> triangles = soup.triangles;
  for (TriangleIndices& t : triangles)
    for (std::uint32_t& v : t) v = welded.pointOf[v];
  return audit(welded.points, triangles, near);
}

/// How the coordinates of a family become those of a file.
enum class Form { exact, floats, turnedFloats, turnedTwiceRounded, farFloats };
constexpr Form kForms[] = {Form::exact, Form::floats, Form::turnedFloats, Form::turnedTwiceRounded,
                           Form::farFloats};

TriangleSoup inForm(const TriangleSoup& soup, Form form, double scale, std::uint32_t seed) {
  const glm::dmat3 upright(1.0), turn = turnOf(seed + 77);
  const double size = scale * sizeOf(soup);
  switch (form) {
    case Form::exact:
      return placed(soup, upright, scale, glm::dvec3(0.0));
    case Form::floats:
      return roundedToFloat(placed(soup, upright, scale, glm::dvec3(0.0)));
    case Form::turnedFloats:
      return roundedToFloat(placed(soup, turn, scale, glm::dvec3(0.3, -0.2, 0.1) * size));
    case Form::turnedTwiceRounded: {
      // The frame that the second rounding is in is that of the weld, and no smaller than the first.
      const TriangleSoup once = roundedToFloat(placed(soup, upright, scale, glm::dvec3(0.0)));
      return roundedToFloat(placed(once, turn, 1.0, glm::dvec3(2.0, 1.5, -1.0) * size));
    }
    case Form::farFloats:
      return roundedToFloat(placed(soup, turn, scale, glm::dvec3(30.0, -50.0, 40.0) * size));
  }
  return soup;
}

struct Family {
  const char* name;
  TriangleSoup soup;
  bool closed;
};

std::vector<Family> families() {
  return {
      {"box", tandem::test::boxSoup(glm::dvec3(1.0, 0.7, 0.4), 2), true},
      {"cylinder", tandem::test::pegSoup({0.3, 1.0, 0.05, {16, 3}}), true},
      {"gear",
       tandem::test::spurGearSoup({.module = 0.1, .teeth = 9, .width = 0.3, .bore = 0.2, .flankPoints = 3}),
       true},
      {"bored block",
       tandem::test::boredBlockSoup(
           {.boreRadius = 0.2, .depth = 0.5, .width = 1.0, .height = 0.5, .facets = {16, 2}}),
       true},
      {"plane", tandem::test::twoStrips(1.0, 4, 4, 3), false},
      {"strips", tandem::test::twoStrips(1.0, 3, 7, 2, 5), false}};
}

std::string describe(const Family& family, Form form, double scale, const EdgeCuts& cuts) {
  return std::string(family.name) + " form " + std::to_string(static_cast<int>(form)) + " scale " +
         std::to_string(scale) + " seed " + std::to_string(cuts.seed) + (cuts.bothSides ? " both" : "") +
         (cuts.crowded ? " crowded" : "");
}

/// Everything that holds of a welded mesh of a family.
void expectWelded(const Family& family, Form form, double scale, const EdgeCuts& cuts) {
  SCOPED_TRACE(describe(family, form, scale, cuts));
  const TriangleSoup soup = inForm(withTJunctions(family.soup, cuts), form, scale, cuts.seed);
  const double rounding = roundingOf(soup), near = 8.0 * rounding;
  const MeshAnalysis a = analyseMesh(soup, kCreaseAngle);
  const Audit before = withoutWeld(soup, near), after = auditOf(a.mesh, near);
  EXPECT_GT(a.defects.tJunctions, 0u);
  EXPECT_GT(before.overlapping, 0u) << "the family has no junctions to weld";
  EXPECT_EQ(after.overlapping, 0u);
  EXPECT_EQ(after.many, 0u);
  EXPECT_EQ(after.open, a.defects.boundaryEdges);
  EXPECT_EQ(a.defects.nonManifoldEdges, 0u);
  EXPECT_EQ(a.defects.flippedFaces, 0u);
  EXPECT_EQ(a.mesh.shellCount, 1u);
  EXPECT_EQ(a.mesh.closed, family.closed);
  EXPECT_EQ(a.mesh.triangles.size() + a.defects.degenerateFaces + a.defects.duplicateFaces,
            soup.triangles.size() + a.defects.tJunctions);
  // A corner moves by the tolerance at most, in a perimeter's length.
  const double size = scale * sizeOf(family.soup);
  EXPECT_NEAR(after.area, before.area, 64.0 * near * size + 1e-12 * before.area);
  if (family.closed) {
    EXPECT_EQ(after.open, 0u);
    const TriangleSoup clean = placed(family.soup, glm::dmat3(1.0), scale, glm::dvec3(0.0));
    EXPECT_NEAR(a.mesh.volume, audit(clean.positions, clean.triangles, 0.0).volume, 8.0 * near * before.area);
  }
  EXPECT_LE(departure(a.mesh, soup), near);
}

class TJunctions : public testing::TestWithParam<double> {};
INSTANTIATE_TEST_SUITE_P(AtScale, TJunctions, testing::ValuesIn(kScales));

TEST_P(TJunctions, OfEveryFamilyAreWelded) {
  std::uint32_t seed = 0;
  for (const Family& family : families())
    for (const Form form : kForms)
      expectWelded(family, form, GetParam(), {.seed = ++seed, .bothSides = seed % 2 == 0});
}

TEST_P(TJunctions, OfManyVerticesOnAnEdgeAreWelded) {
  for (const Family& family : families())
    expectWelded(family, Form::turnedFloats, GetParam(),
                 {.seed = 11, .share = 0.3, .most = 24, .bothSides = true});
}

/// Vertices 1e-5 of the size apart: slivers whose width rounding is a share of.
TEST_P(TJunctions, InCrowdsAreWelded) {
  for (const Family& family : families())
    for (const bool both : {false, true})
      expectWelded(family, Form::turnedFloats, GetParam(),
                   {.seed = 12, .share = 0.3, .most = 5, .bothSides = both, .crowded = true});
}

TEST_P(TJunctions, OfStripsWhoseRowsDoNotMatchAreWelded) {
  for (std::uint32_t seed = 1; seed <= 8; ++seed) {
    const TriangleSoup soup =
        roundedToFloat(placed(tandem::test::twoStrips(1.0, 3 + static_cast<int>(seed), 20, 2, seed),
                              turnOf(seed), GetParam(), glm::dvec3(0.0)));
    const MeshAnalysis a = analyseMesh(soup, kCreaseAngle);
    const Audit after = auditOf(a.mesh, 8.0 * roundingOf(soup));
    EXPECT_EQ(a.mesh.shellCount, 1u) << seed;
    EXPECT_EQ(after.overlapping, 0u) << seed;
    EXPECT_EQ(after.many, 0u) << seed;
    // What is left is the outline.
    EXPECT_EQ(after.open, 3u + seed + 20u + 8u) << seed;
  }
}

// --- what must not be welded

/// Two strips of which one stands off by `off` roundings, in the plane or across it.
MeshAnalysis strippedApart(double off, const glm::dvec3& direction, double scale) {
  TriangleSoup soup = tandem::test::twoStrips(scale, 5, 8, 2);
  const double rounding = roundingOf(soup);
  for (std::size_t t = 0; t < soup.triangles.size(); ++t)
    if (soup.positions[soup.triangles[t][0]].y >= 0.0 && soup.positions[soup.triangles[t][1]].y >= 0.0 &&
        soup.positions[soup.triangles[t][2]].y >= 0.0)
      for (const std::uint32_t v : soup.triangles[t]) soup.positions[v] += off * rounding * direction;
  return analyseMesh(soup, kCreaseAngle);
}

TEST_P(TJunctions, FartherThanRoundingStayOpen) {
  for (const glm::dvec3& direction : {glm::dvec3(0, 1, 0), glm::dvec3(0, 0, 1), glm::dvec3(0, 0.6, -0.8)}) {
    EXPECT_GT(strippedApart(2.0, direction, GetParam()).defects.tJunctions, 0u);
    for (const double off : {12.0, 30.0, 1000.0, 1e6}) {
      const MeshAnalysis a = strippedApart(off, direction, GetParam());
      EXPECT_EQ(a.defects.tJunctions, 0u) << off;
      EXPECT_EQ(a.mesh.shellCount, 2u) << off;
      EXPECT_EQ(a.mesh.triangles.size(), 52u) << off;
    }
  }
}

TriangleSoup sheet(int columns, int rows, const glm::dmat3& turn, const glm::dvec3& shift) {
  // The lower strip alone, about its own middle.
  TriangleSoup strips = tandem::test::twoStrips(1.0, columns, 1, rows), out;
  for (std::size_t t = 0; t + 2 * static_cast<std::size_t>(rows) < strips.triangles.size(); ++t) {
    const auto first = static_cast<std::uint32_t>(out.positions.size());
    for (const std::uint32_t v : strips.triangles[t])
      out.positions.push_back(turn * (strips.positions[v] + glm::dvec3(0.0, 0.25, 0.0)) + shift);
    out.triangles.push_back({first, first + 1, first + 2});
    out.triangleMaterial.push_back(0);
  }
  return out;
}

void expectUnharmed(const TriangleSoup& soup, std::uint32_t shells) {
  const MeshAnalysis a = analyseMesh(soup, kCreaseAngle);
  EXPECT_EQ(a.defects.tJunctions, 0u);
  EXPECT_EQ(a.defects.flippedFaces, 0u);
  EXPECT_EQ(a.defects.nonManifoldEdges, 0u);
  EXPECT_EQ(a.mesh.triangles.size(), soup.triangles.size());
  EXPECT_EQ(a.mesh.shellCount, shells);
}

TEST_P(TJunctions, ThatPlatesWithoutThicknessSeemToHaveStayOpen) {
  for (const bool facing : {false, true}) {
    TriangleSoup front = sheet(3, 2, glm::dmat3(1.0), glm::dvec3(0.0)),
                 back = sheet(5, 4, glm::dmat3(1.0), glm::dvec3(0.0));
    if (facing) back = tandem::test::insideOut(back);
    // The outlines of two coincident rectangles share their corners alone.
    const TriangleSoup plate = roundedToFloat(
        placed(tandem::test::joined(front, back), turnOf(3), GetParam(), glm::dvec3(0.1 * GetParam())));
    const MeshAnalysis a = analyseMesh(plate, kCreaseAngle);
    EXPECT_EQ(a.defects.tJunctions, 0u);
    EXPECT_EQ(a.mesh.shellCount, 2u);
    EXPECT_EQ(a.mesh.triangles.size(), plate.triangles.size());
    EXPECT_FALSE(a.mesh.closed);
  }
}

TEST_P(TJunctions, WhereSheetsCrossOrTouchStayOpen) {
  const glm::dmat3 upright(1.0), steep(1, 0, 0, 0, 0, 1, 0, -1, 0);
  const double scale = GetParam();
  const auto joint = [&](const TriangleSoup& a, const TriangleSoup& b) {
    return placed(tandem::test::joined(a, b), upright, scale, glm::dvec3(0.0));
  };
  const TriangleSoup flat = sheet(4, 4, upright, glm::dvec3(0.0));
  // Through each other, vertices of one on edges and vertices of the other.
  expectUnharmed(joint(flat, sheet(6, 2, steep, glm::dvec3(0.0))), 2);
  // Standing on the middle of the other.
  expectUnharmed(joint(flat, sheet(6, 2, steep, glm::dvec3(0.0, 0.0, 0.25))), 2);
  // A corner on the middle of the other's border, and a border that crosses its border.
  expectUnharmed(joint(flat, sheet(1, 1, steep, glm::dvec3(1.0 - 0.03125, 0.25, 0.0))), 2);
  expectUnharmed(joint(flat, sheet(1, 1, steep, glm::dvec3(0.03125, 0.25, 0.1))), 2);
}

TEST_P(TJunctions, OfAClosedMeshAreNotSoughtAndItsBitsStay) {
  for (const Family& family : families()) {
    const TriangleSoup soup = placed(family.soup, glm::dmat3(1.0), GetParam(), glm::dvec3(0.0));
    const MeshAnalysis a = analyseMesh(soup, kCreaseAngle);
    if (!family.closed) continue;
    EXPECT_EQ(a.defects.tJunctions, 0u);
    ASSERT_EQ(a.mesh.triangles.size(), soup.triangles.size());
    for (std::size_t t = 0; t < soup.triangles.size(); ++t)
      for (int c = 0; c < 3; ++c)
        EXPECT_LE(
            glm::distance(a.mesh.positions[a.mesh.triangles[t][c]], soup.positions[soup.triangles[t][c]]),
            8.0 * roundingOf(soup));
  }
}

// --- attributes, dropped faces, the rounding of a file

TEST_P(TJunctions, KeepMaterialsAndInterpolateTextureCoordinates) {
  TriangleSoup clean = tandem::test::boxSoup(glm::dvec3(1.0, 0.7, 0.4), 2);
  for (std::size_t t = 0; t < clean.triangles.size(); ++t)
    clean.triangleMaterial[t] = static_cast<std::uint16_t>(t % 5);
  TriangleSoup soup =
      roundedToFloat(placed(withTJunctions(clean, {.seed = 4, .share = 0.8, .bothSides = true}), turnOf(1),
                            GetParam(), glm::dvec3(0.0)));
  const auto uvAt = [&](const glm::dvec3& p) {
    return glm::vec2(0.5 + glm::dvec2(0.3 * p.x - 0.2 * p.z, 0.2 * p.y + 0.1 * p.x) / GetParam());
  };
  double area[5] = {}, welded[5] = {};
  const auto areaOf = [](const std::vector<glm::dvec3>& p, const TriangleIndices& t) {
    return 0.5 * glm::length(glm::cross(p[t[1]] - p[t[0]], p[t[2]] - p[t[0]]));
  };
  for (std::size_t t = 0; t < soup.triangles.size(); ++t) {
    auto& uv = soup.triangleUv.emplace_back();
    for (int c = 0; c < 3; ++c) uv[c] = uvAt(soup.positions[soup.triangles[t][c]]);
    area[soup.triangleMaterial[t]] += areaOf(soup.positions, soup.triangles[t]);
  }
  const Mesh mesh = analyseMesh(soup, kCreaseAngle).mesh;
  ASSERT_EQ(mesh.triangleUv.size(), mesh.triangles.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (int c = 0; c < 3; ++c)
      EXPECT_LE(glm::length(mesh.triangleUv[t][c] - uvAt(mesh.positions[mesh.triangles[t][c]])), 1e-5f);
    welded[mesh.triangleMaterial[t]] += areaOf(mesh.positions, mesh.triangles[t]);
  }
  for (int m = 0; m < 5; ++m) EXPECT_NEAR(welded[m], area[m], 1e-4 * area[m]);
}

TEST_P(TJunctions, ThatDroppedFacesLeaveAreWelded) {
  // A face without area closes the edge of its neighbour, whose other side has a vertex in its middle.
  TriangleSoup soup = withTJunctions(tandem::test::boxSoup(glm::dvec3(1.0, 0.5, 0.25), 2), {.seed = 9});
  std::size_t added = 0;
  const MeshAnalysis bare = analyseMesh(soup, kCreaseAngle);
  for (std::size_t t = 0; t < 12; ++t) {
    const TriangleIndices c = soup.triangles[t];
    const auto middle = static_cast<std::uint32_t>(soup.positions.size());
    soup.positions.push_back(0.5 * (soup.positions[c[0]] + soup.positions[c[1]]));
    soup.triangles.push_back({c[0], middle, c[1]});
    soup.triangleMaterial.push_back(0);
    ++added;
  }
  const MeshAnalysis a =
      analyseMesh(placed(soup, glm::dmat3(1.0), GetParam(), glm::dvec3(0.0)), kCreaseAngle);
  EXPECT_TRUE(a.mesh.closed);
  EXPECT_EQ(a.defects.degenerateFaces, added);
  EXPECT_NEAR(a.mesh.volume, 0.125 * std::pow(GetParam(), 3.0), 1e-6 * std::pow(GetParam(), 3.0));
}

/// A file with a movable part whose mesh is a child at `shift` of it. The vertices on the edges of the mesh
/// are `off` roundings of its own coordinates away from them.
tests::GltfBuilder fileWithStrips(double scale, double shift, double off) {
  TriangleSoup soup = tandem::test::twoStrips(scale, 5, 8, 2);
  const double rounding = roundingOf(soup);
  std::vector<float> positions;
  for (const TriangleIndices& t : soup.triangles) {
    double least = 1e300;
    for (const std::uint32_t v : t) least = std::min(least, soup.positions[v].y);
    for (const std::uint32_t v : t) {
      const glm::dvec3 p = soup.positions[v] + (least >= 0.0 ? off * rounding : 0.0) * glm::dvec3(0, 0, 1);
      for (int axis = 0; axis < 3; ++axis) positions.push_back(static_cast<float>(p[axis]));
    }
  }
  tests::GltfBuilder builder;
  const int child =
      builder.addOrphan({{"mesh", builder.addMesh(builder.addPositions(positions), -1, 4, -1, "strips")},
                         {"translation", {shift * scale, -2.0 * shift * scale, 0.0}}});
  builder.addNode({{"name", "part"},
                   {"children", tests::GltfBuilder::Json::array({child})},
                   {"extensions", {{"KHR_physics_rigid_bodies", {{"motion", {{"mass", 1.0}}}}}}}});
  builder.json["extensionsUsed"] = tests::GltfBuilder::Json::array({"KHR_physics_rigid_bodies"});
  return builder;
}

std::uint64_t counted(const Scene& scene, const std::string& code) {
  for (const Finding& finding : scene.findings)
    if (finding.code == code) return finding.count;
  return 0;
}

TEST_P(TJunctions, AreThoseOfTheFrameInWhichAFileRoundsThem) {
  for (const double shift : {0.0, 3.0, 1000.0}) {
    const Scene on = loaded(fileWithStrips(GetParam(), shift, 2.0));
    EXPECT_EQ(counted(on, "t-junctions"), 11u) << shift;
    ASSERT_EQ(on.meshes.size(), 1u);
    EXPECT_EQ(on.meshes[0].shellCount, 1u) << shift;
    const Scene beside = loaded(fileWithStrips(GetParam(), shift, 40.0));
    EXPECT_EQ(counted(beside, "t-junctions"), 0u) << shift;
    EXPECT_EQ(beside.meshes[0].shellCount, 2u) << shift;
  }
}

// --- bounded work

/// Pages that share their spine, each cut at places of its own: every vertex lies on the edges of all others.
TriangleSoup book(int pages, int cuts) {
  TriangleSoup soup;
  for (int page = 0; page < pages; ++page) {
    const double angle = std::numbers::pi * page / pages;
    const glm::dvec3 out(std::cos(angle), std::sin(angle), 0.0);
    for (int i = 0; i < cuts; ++i) {
      const double low = i == 0 ? 0.0 : (i + 0.9 * page / pages) / cuts,
                   high = i + 1 == cuts ? 1.0 : (i + 1 + 0.9 * page / pages) / cuts;
      const auto first = static_cast<std::uint32_t>(soup.positions.size());
      soup.positions.insert(soup.positions.end(), {{0, 0, low}, {0, 0, high}, out + glm::dvec3(0, 0, 0.5)});
      soup.triangles.push_back({first, first + 1, first + 2});
      soup.triangleMaterial.push_back(0);
    }
  }
  return soup;
}

TEST(TJunctionWork, IsBoundedWhereEveryVertexLiesOnManyEdges) {
  const TriangleSoup soup = book(60, 10);
  const MeshAnalysis a = analyseMesh(soup, kCreaseAngle);
  EXPECT_EQ(a.mesh.triangles.size() + a.defects.degenerateFaces + a.defects.duplicateFaces,
            soup.triangles.size() + a.defects.tJunctions);
  // Each of 600 edges on the spine has the vertices of 59 other pages on it.
  EXPECT_LE(a.defects.tJunctions, 600u * 60u);
}

TEST(TJunctionWork, DoesNotDependOnTheOrderOfRuns) {
  const TriangleSoup soup = inForm(withTJunctions(tandem::test::boxSoup(glm::dvec3(1.0, 0.7, 0.4), 4),
                                                  {.seed = 21, .share = 0.9, .most = 6, .bothSides = true}),
                                   Form::turnedFloats, 1.0, 1);
  const MeshAnalysis a = analyseMesh(soup, kCreaseAngle), b = analyseMesh(soup, kCreaseAngle);
  EXPECT_EQ(a.mesh.triangles, b.mesh.triangles);
  EXPECT_EQ(a.mesh.positions, b.mesh.positions);
}

}  // namespace
}  // namespace tandem::assets
