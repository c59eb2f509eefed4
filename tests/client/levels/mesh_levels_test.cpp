#include "client/levels/mesh_levels.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <map>
#include <random>
#include <set>

#include <glm/geometric.hpp>

#include "assets/generate/bench_meshes.h"
#include "assets/generate/large_assembly.h"
#include "client/levels/level_error.h"
#include "haptics/geometry/triangle_math.h"

namespace tandem::client {
namespace {

const auto kNever = [] { return false; };

using Triangles = std::vector<haptics::Triangle>;

Triangles trianglesOf(const assets::Mesh& mesh) {
  Triangles out;
  for (const auto& t : mesh.triangles)
    out.push_back({mesh.positions[t[0]], mesh.positions[t[1]], mesh.positions[t[2]]});
  return out;
}

Triangles trianglesOf(const RenderMesh& mesh) {
  Triangles out;
  const auto at = [&](std::size_t i) { return glm::dvec3(mesh.vertices[mesh.indices[i]].position); };
  for (std::size_t i = 0; i < mesh.indices.size(); i += 3) out.push_back({at(i), at(i + 1), at(i + 2)});
  return out;
}

/// The largest distance of points at random on `from` to any triangle of `to`.
double furthest(const Triangles& from, const Triangles& to, int samples, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> share(0.0, 1.0);
  double most = 0.0;
  for (int i = 0; i < samples; ++i) {
    const haptics::Triangle& t = from[random() % from.size()];
    double u = share(random), v = share(random);
    if (u + v > 1.0) u = 1.0 - u, v = 1.0 - v;
    const glm::dvec3 p = t.a + u * (t.b - t.a) + v * (t.c - t.a);
    double nearest = 1e300;
    for (const haptics::Triangle& other : to)
      nearest = std::min(nearest, glm::distance(p, haptics::closestPointOnTriangle(p, other).point));
    most = std::max(most, nearest);
  }
  return most;
}

/// What a level is off by brute force.
double foundError(const assets::Mesh& exact, const RenderMesh& level) {
  const Triangles a = trianglesOf(exact), b = trianglesOf(level);
  return std::max(furthest(a, b, 2000, 1), furthest(b, a, 500, 2));
}

bool isHonest(const assets::Mesh& exact, const Level& level) {
  return foundError(exact, level.mesh) <= level.error * 1.001;
}

/// Whether every edge, by the places of its ends, is passed as often one way as the other.
bool isClosed(const RenderMesh& mesh) {
  using Place = std::array<float, 3>;
  std::map<std::pair<Place, Place>, int> passed;
  const auto place = [&](std::size_t i) {
    const glm::vec3& p = mesh.vertices[mesh.indices[i]].position;
    return Place{p.x, p.y, p.z};
  };
  for (std::size_t t = 0; t < mesh.indices.size(); t += 3)
    for (std::size_t k = 0; k < 3; ++k) {
      const Place a = place(t + k), b = place(t + (k + 1) % 3);
      a < b ? ++passed[{a, b}] : --passed[{b, a}];
    }
  return std::all_of(passed.begin(), passed.end(), [](const auto& edge) { return edge.second == 0; });
}

double areaOf(const RenderMesh& mesh, std::uint16_t material) {
  double area = 0.0;
  const Triangles triangles = trianglesOf(mesh);
  for (const RenderRange& range : mesh.ranges)
    if (range.material == material)
      for (std::uint32_t i = range.firstIndex / 3; i < (range.firstIndex + range.indexCount) / 3; ++i)
        area += 0.5 * glm::length(haptics::areaVector(triangles[i]));
  return area;
}

/// A casting and a gear.
const assets::Scene& smallAssembly() {
  static const assets::Scene scene = generate::largeAssembly(2, 6000);
  return scene;
}

TEST(MeshLevels, AreOffByNoMoreThanTheySayByBruteForce) {
  for (const assets::Mesh& mesh : smallAssembly().meshes) {
    const double size = glm::length(mesh.bounds.max - mesh.bounds.min);
    std::vector<Level> levels = makeLevels(mesh, kNever);
    ASSERT_FALSE(levels.empty());
    for (const Level& level : levels) {
      EXPECT_TRUE(isHonest(mesh, level)) << foundError(mesh, level.mesh) << " of " << level.error;
      EXPECT_LT(level.error, 1.3 * foundError(mesh, level.mesh) + 3e-5 * size) << "nor much less";
    }
    Level lying = levels.back();
    for (RenderVertex& vertex : lying.mesh.vertices)
      vertex.position.x += static_cast<float>(2.0 * lying.error);
    EXPECT_FALSE(isHonest(mesh, lying)) << "a level that is off by more than it says is found out";
    const Level standIn = standInFor(mesh);
    EXPECT_TRUE(isHonest(mesh, standIn));
    EXPECT_LT(standIn.error, 0.05 * size);
  }
}

TEST(MeshLevels, GetFewerTrianglesAndLessExactOneByOneAndStayClosed) {
  for (const assets::Mesh& mesh : smallAssembly().meshes) {
    ASSERT_TRUE(mesh.closed);
    EXPECT_TRUE(isClosed(standInFor(mesh).mesh));
    std::size_t left = 3 * mesh.triangles.size();
    double error = 0.0;
    for (const Level& level : makeLevels(mesh, kNever)) {
      EXPECT_TRUE(isClosed(level.mesh));
      EXPECT_LT(2 * level.mesh.indices.size(), left);
      EXPECT_GE(level.error, error);
      left = level.mesh.indices.size();
      error = level.error;
    }
  }
}

// Nothing of a flat sheet is off by distance, wherever the lines on it go: they have to be kept by
// themselves.
TEST(MeshLevels, KeepOutlineAndBordersOfColoursOfAFlatSheet) {
  assets::Mesh sheet = generate::flatSheet(0.1, 80);
  for (std::size_t t = 0; t < sheet.triangles.size(); ++t) {
    const auto& c = sheet.triangles[t];
    const glm::dvec3 middle = (sheet.positions[c[0]] + sheet.positions[c[1]] + sheet.positions[c[2]]) / 3.0;
    sheet.triangleMaterial[t] = glm::length(glm::dvec2(middle)) < 0.03 ? 1 : 0;
  }
  const RenderMesh exact = makeRenderMesh(sheet);
  const std::vector<Level> levels = makeLevels(sheet, kNever);
  ASSERT_FALSE(levels.empty());
  for (const Level& level : levels) {
    EXPECT_NEAR(areaOf(level.mesh, 0) + areaOf(level.mesh, 1), 0.01, 1e-8);
    EXPECT_NEAR(areaOf(level.mesh, 1), areaOf(exact, 1), 0.02 * areaOf(exact, 1));
  }
}

TEST(MeshLevels, HaveTheNormalsOfTheExactMeshOnBothSidesOfACrease) {
  const assets::Mesh& gear = smallAssembly().meshes[1];
  const RenderMesh exact = makeRenderMesh(gear);
  using Key = std::array<float, 6>;
  const auto key = [](const RenderVertex& v) {
    return Key{v.position.x, v.position.y, v.position.z, v.normal.x, v.normal.y, v.normal.z};
  };
  std::set<Key> known;
  for (const RenderVertex& vertex : exact.vertices) known.insert(key(vertex));
  for (const Level& level : makeLevels(gear, kNever)) {
    EXPECT_FALSE(level.mesh.featureEdges.empty());
    for (const RenderVertex& vertex : level.mesh.vertices) EXPECT_TRUE(known.contains(key(vertex)));
  }
}

TEST(MeshLevels, StopWhenTheyAreToldTo) {
  int asked = 0;
  EXPECT_TRUE(makeLevels(smallAssembly().meshes[0], [&] { return ++asked > 1; }).empty());
  EXPECT_LE(asked, 4);
}

TEST(MeshLevels, AreNotMadeOfAMeshWithoutTopology) {
  EXPECT_TRUE(makeLevels(generate::sphereMesh(0.1, 5000, generate::Topology::never), kNever).empty());
}

TEST(LevelError, ABoundHoldsWhereTheNearestTrianglesChangeWithinAPiece) {
  // A roof over a flat square: the ridge, 1 mm high, lies in no corner of the square's two triangles.
  assets::Mesh flat, roof;
  flat.positions = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
  flat.triangles = {{0, 1, 2}, {0, 2, 3}};
  roof.positions = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}, {0, 0, 0.1}};
  roof.triangles = {{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}};
  for (assets::Mesh* mesh : {&flat, &roof}) {
    mesh->bounds.min = {-1, -1, 0};
    mesh->bounds.max = {1, 1, mesh == &roof ? 0.1 : 0.0};
  }
  const haptics::TriangleBvh tree(roof, 1);
  const double found = furthest(trianglesOf(flat), trianglesOf(roof), 20'000, 3);
  EXPECT_GE(distanceBound(flat, tree), found);
  EXPECT_LE(distanceBound(flat, tree), 1.1 * found);
}

}  // namespace
}  // namespace tandem::client
