#include "haptics/scene/distance_field.h"

#include <cmath>
#include <cstdlib>
#include <functional>
#include <random>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "assets/gltf/load_gltf.h"
#include "haptics/geometry/mesh_sides.h"
#include "haptics/geometry/triangle_bvh.h"
#include "haptics/geometry/winding_tree.h"
#include "tests/support/part_meshes.h"
#include "tests/support/shapes.h"

namespace tandem::haptics {
namespace {

using assets::Mesh;
using test::boxMesh;
using test::sphereMesh;

DistanceField::Options coarse(double cells = 64.0) {
  DistanceField::Options options;
  options.tolerance = 1.0;  // replaced by the caller's scale
  options.smallestCell = 1.0 / cells;
  return options;
}

/// Options for a mesh of this size, so coarse that a test is quick.
DistanceField::Options optionsFor(const Mesh& mesh, double cells = 64.0, double tolerance = 1e-4) {
  const double diagonal = glm::distance(mesh.bounds.min, mesh.bounds.max);
  DistanceField::Options options = coarse(cells);
  options.smallestCell *= diagonal;
  options.tolerance = tolerance * diagonal;
  return options;
}

/// 1 outside, -1 inside, as crossings of three rays tell.
double sideByRays(const TriangleBvh& tree, const glm::dvec3& p) {
  int votes = 0;
  for (const glm::dvec3& way :
       {glm::dvec3(0.61, 0.53, 0.59), glm::dvec3(-0.47, 0.71, 0.52), glm::dvec3(0.31, -0.83, -0.46)})
    votes += tree.signedCrossings(p, p + 100.0 * way) > 0 ? -1 : 1;
  return votes > 0 ? 1.0 : -1.0;
}

using SideOf = std::function<double(const glm::dvec3&)>;

/// A mesh, its tree and its field.
struct Baked {
  Mesh mesh;
  TriangleBvh tree;
  DistanceField field;

  Baked(Mesh given, const DistanceField::Options& options)
      : mesh(std::move(given)), tree(mesh, 1), field(tree, options) {}
  explicit Baked(Mesh given) : Baked(given, optionsFor(given)) {}

  double distance(const glm::dvec3& p) const {
    MeshPoint nearest;
    tree.closestPoint(p, 1e300, nearest);
    return nearest.distance;
  }
  double diagonal() const { return glm::distance(mesh.bounds.min, mesh.bounds.max); }
  Result<DistanceField> unpack(std::span<const std::byte> bytes) const {
    return DistanceField::unpack(bytes, mesh.triangles.size());
  }
  /// The triangles that the field lists at a place.
  std::vector<std::uint32_t> listedAt(const glm::vec3& p) const {
    DistanceField::Triangles near;
    static_cast<void>(field.read(p, near));
    return {near.begin(), near.end()};
  }
};

/// m, the distance of the nearest one of some triangles.
double distanceAmong(const Mesh& mesh, std::span<const std::uint32_t> triangles, const glm::dvec3& p) {
  double least = 1e300;
  for (const std::uint32_t t : triangles) {
    const auto& [a, b, c] = mesh.triangles[t];
    const Triangle corners{mesh.positions[a], mesh.positions[b], mesh.positions[c]};
    least = std::min(least, glm::distance(p, closestPointOnTriangle(p, corners).point));
  }
  return least;
}

/// Whether no triangle is nearer than those that the field lists, if it lists any.
bool listHolds(const Baked& baked, const glm::vec3& p) {
  const std::vector<std::uint32_t> near = baked.listedAt(p);
  const glm::dvec3 at = glm::dvec3(p) + baked.field.origin();
  return near.empty() || distanceAmong(baked.mesh, near, at) <= baked.distance(at) + 1e-14 * baked.diagonal();
}

/// How far a reading is beyond its bound, m; not above 0 if the bound holds.
double excess(const Baked& baked, const glm::vec3& p, const SideOf& side) {
  const glm::dvec3 at = glm::dvec3(p) + baked.field.origin();
  const DistanceField::Reading reading = baked.field.read(p);
  const double truth = side(at) * baked.distance(at);
  if (reading.error == 0.0f) return static_cast<double>(reading.distance) - truth;
  return std::abs(truth - static_cast<double>(reading.distance)) - static_cast<double>(reading.error);
}

/// Attacks the bound in the box around the mesh, near its surface, near its edges, at the borders of cells
/// and where the gradient turns; returns the worst excess.
double attack(const Baked& baked, const SideOf& side, int count = 4000) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  const auto& triangles = baked.mesh.triangles;
  const glm::dvec3 origin = baked.field.origin();
  const double diagonal = baked.diagonal();
  double worst = -1e300;
  int wrongLists = 0;
  const auto tryAt = [&](const glm::dvec3& p) {
    const glm::vec3 at(p - origin);
    worst = std::max(worst, excess(baked, at, side));
    wrongLists += listHolds(baked, at) ? 0 : 1;
  };
  for (int i = 0; i < count; ++i) {
    const glm::dvec3 any(unit(random), unit(random), unit(random));
    tryAt(origin + 0.6 * diagonal * any);
    const auto& t = triangles[random() % triangles.size()];
    const glm::dvec3 &a = baked.mesh.positions[t[0]], &b = baked.mesh.positions[t[1]],
                     &c = baked.mesh.positions[t[2]];
    const double u = 0.5 + 0.5 * unit(random), v = 0.5 + 0.5 * unit(random);
    const glm::dvec3 on = a + u * (b - a) + (1.0 - u) * v * (c - a);
    const glm::dvec3 edge = a + u * (b - a);
    const double scale = diagonal * std::pow(10.0, -2.5 + 1.5 * unit(random));
    tryAt(on + scale * any);
    tryAt(edge + scale * any);
    // On the grid of the smallest cells.
    const double cell = baked.field.smallestCell();
    const glm::dvec3 near = on + scale * any - origin;
    tryAt(origin + cell * glm::round(near / cell));
    // Across where the nearest point jumps.
    const glm::dvec3 p = on + scale * any;
    MeshPoint nearest;
    baked.tree.closestPoint(p, 1e300, nearest);
    tryAt(nearest.point);
    tryAt(p + 2.0 * (p - nearest.point));
  }
  EXPECT_EQ(wrongLists, 0);
  return worst;
}

double attackClosed(const Baked& baked, int count = 4000) {
  return attack(
      baked, [&](const glm::dvec3& p) { return sideByRays(baked.tree, p); }, count);
}

/// Every triangle with corners of its own, of a box whose faces do not quite meet.
Mesh looseBox(double size, double gap) {
  const Mesh box = boxMesh(glm::dvec3(size));
  test::ShapeBuilder b;
  for (const auto& t : box.triangles) {
    const glm::dvec3 normal = glm::normalize(
        glm::cross(box.positions[t[1]] - box.positions[t[0]], box.positions[t[2]] - box.positions[t[0]]));
    std::uint32_t first = 0;
    for (std::size_t c = 0; c < 3; ++c) {
      const glm::dvec3 p = box.positions[t[c]] + gap * normal;
      const std::uint32_t v = b.vertex(p.x, p.y, p.z);
      if (c == 0) first = v;
    }
    b.triangle(first, first + 1, first + 2);
  }
  return b.mesh();
}

/// Two closed boxes that overlap, in one mesh.
Mesh overlappingBoxes() {
  test::ShapeBuilder b;
  for (const double shift : {0.0, 0.5}) {
    const Mesh box = boxMesh(glm::dvec3(1.0));
    const auto first = static_cast<std::uint32_t>(b.soup.positions.size());
    for (const glm::dvec3& p : box.positions) b.vertex(p.x + shift, p.y + 0.4 * shift, p.z + 0.3 * shift);
    for (const auto& t : box.triangles) b.triangle(first + t[0], first + t[1], first + t[2]);
  }
  return b.mesh();
}

TEST(DistanceField, HoldsItsBoundAroundABox) {
  const Baked baked(boxMesh({0.03, 0.02, 0.01}));
  EXPECT_TRUE(baked.field.solid());
  EXPECT_LE(attackClosed(baked), 0.0);
}

TEST(DistanceField, IsExactOnPlanes) {
  const Baked baked(boxMesh({0.03, 0.02, 0.01}));
  for (const double height : {-1e-3, -1e-5, 0.0, 1e-5, 1e-3}) {
    const auto reading = baked.field.read(glm::vec3(0.002, 0.001, 0.005 + height));
    EXPECT_NEAR(reading.distance, height, 1e-6 * baked.diagonal());
    EXPECT_LE(reading.error, 2e-6 * baked.diagonal());
    EXPECT_NEAR(reading.gradient.z, 1.0, 1e-6);
  }
}

TEST(DistanceField, HoldsItsBoundAroundASphere) {
  const Baked baked(sphereMesh(0.01, 24));
  EXPECT_LE(attackClosed(baked), 0.0);
}

TEST(DistanceField, HoldsItsBoundAroundAThinPlate) {
  const Baked baked(boxMesh({0.04, 0.03, 0.0005}), optionsFor(boxMesh({0.04, 0.03, 0.0005}), 200.0));
  EXPECT_LE(attackClosed(baked), 0.0);
}

TEST(DistanceField, KnowsTheCavityOfAShell) {
  test::ShapeBuilder b;
  for (const double size : {1.0, 0.5}) {
    const Mesh box = boxMesh(glm::dvec3(size));
    const auto first = static_cast<std::uint32_t>(b.soup.positions.size());
    for (const glm::dvec3& p : box.positions) b.vertex(p.x, p.y, p.z);
    for (const auto& t : box.triangles) {
      if (size == 1.0) b.triangle(first + t[0], first + t[1], first + t[2]);
      if (size != 1.0) b.triangle(first + t[0], first + t[2], first + t[1]);
    }
  }
  const Baked baked(b.mesh());
  EXPECT_GT(baked.field.read({0.0f, 0.0f, 0.0f}).distance, 0.1f);
  EXPECT_LT(baked.field.read({0.375f, 0.0f, 0.0f}).distance, -0.1f);
  EXPECT_LE(attackClosed(baked), 0.0);
}

TEST(DistanceField, KnowsTheInsideOfShellsThatOverlap) {
  const Baked baked(overlappingBoxes());
  ASSERT_TRUE(baked.field.solid());
  const glm::vec3 middle(glm::dvec3(0.25, 0.1, 0.075) - baked.field.origin());
  EXPECT_LT(baked.field.read(middle).distance, 0.0f);
  EXPECT_LE(attackClosed(baked), 0.0);
}

TEST(DistanceField, KnowsTheInsideOfASoupWithGaps) {
  const Baked baked(looseBox(1.0, 1e-3));
  ASSERT_TRUE(baked.field.solid());
  EXPECT_LT(baked.field.read({0.1f, 0.2f, 0.1f}).distance, -0.1f);
  EXPECT_GT(baked.field.read({0.53f, 0.2f, 0.1f}).distance, 0.0f);
  const WindingTree winding(baked.mesh);
  EXPECT_LE(attack(baked, [&](const glm::dvec3& p) { return winding.at(p) > 0.5 ? -1.0 : 1.0; }), 0.0);
}

TEST(DistanceField, HasNoInsideOfASheet) {
  const Baked baked(test::sheetMesh(0.1, 8));
  EXPECT_FALSE(baked.field.solid());
  EXPECT_LE(attack(baked, [](const glm::dvec3&) { return 1.0; }), 0.0);
}

TEST(DistanceField, TellsAtLeastHowFarThingsAreBeyondItsGrid) {
  const Baked baked(boxMesh({2.0, 1.0, 1.0}));
  const auto reading = baked.field.read({11.0f, 0.0f, 0.0f});
  EXPECT_EQ(reading.error, 0.0f);
  EXPECT_LE(reading.distance, 10.0f);
  EXPECT_GE(reading.distance, 9.99f);
}

TEST(DistanceField, DoesNotDependOnTheNumberOfThreads) {
  auto options = optionsFor(sphereMesh(0.01, 24));
  options.threads = 1;
  const Baked one(sphereMesh(0.01, 24), options);
  options.threads = 3;
  const Baked three(sphereMesh(0.01, 24), options);
  EXPECT_EQ(one.field.pack(), three.field.pack());
}

TEST(DistanceField, IsTheSameFieldAtEveryScale) {
  const Baked baked(sphereMesh(1.0, 16));
  for (const double scale : {1e-3, 20.0}) {
    const Baked scaled(sphereMesh(scale, 16));
    EXPECT_NEAR(static_cast<double>(scaled.field.cells()), static_cast<double>(baked.field.cells()),
                0.01 * static_cast<double>(baked.field.cells()));
    std::mt19937 random(1);
    std::uniform_real_distribution<float> unit(-1.1f, 1.1f);
    for (int i = 0; i < 1000; ++i) {
      const glm::vec3 p(unit(random), unit(random), unit(random));
      const auto a = baked.field.read(p), b = scaled.field.read(static_cast<float>(scale) * p);
      EXPECT_NEAR(b.distance / scale, a.distance, a.error + b.error / scale);
    }
  }
}

TEST(DistanceField, KeepsToTheMemoryThatItIsGiven) {
  auto options = optionsFor(sphereMesh(0.01, 24), 200.0);
  options.memory = 1u << 20;
  const Baked baked(sphereMesh(0.01, 24), options);
  EXPECT_LE(baked.field.memory(), options.memory + 4096);
  EXPECT_TRUE(baked.field.coarsened());
  EXPECT_GT(baked.field.smallestCell(), 1.5 * options.smallestCell);
  EXPECT_LE(attackClosed(baked, 500), 0.0);
}

TEST(DistanceField, ComesBackFromItsBytes) {
  const Baked baked(sphereMesh(0.01, 12));
  const std::vector<std::byte> bytes = baked.field.pack();
  const Result<DistanceField> again = baked.unpack(bytes);
  ASSERT_TRUE(again.ok()) << again.error().message;
  EXPECT_EQ(again->pack(), bytes);
  EXPECT_EQ(again->solid(), baked.field.solid());
  EXPECT_EQ(again->read({0.001f, 0.002f, 0.003f}).distance,
            baked.field.read({0.001f, 0.002f, 0.003f}).distance);
}

TEST(DistanceField, RefusesBytesThatAreCutShort) {
  const Baked baked(boxMesh(glm::dvec3(1.0)), optionsFor(boxMesh(glm::dvec3(1.0)), 16.0));
  const std::vector<std::byte> bytes = baked.field.pack();
  for (std::size_t size = 0; size < bytes.size(); size += 1 + size / 7)
    EXPECT_FALSE(baked.unpack(std::span(bytes).first(size)).ok()) << size;
}

TEST(DistanceField, SurvivesBytesThatAreWrong) {
  const Baked baked(boxMesh(glm::dvec3(1.0)), optionsFor(boxMesh(glm::dvec3(1.0)), 16.0));
  const std::vector<std::byte> bytes = baked.field.pack();
  std::mt19937 random(5);
  std::uniform_real_distribution<float> unit(-1.0f, 1.0f);
  int refused = 0;
  for (int i = 0; i < 2000; ++i) {
    std::vector<std::byte> bad = bytes;
    const std::size_t at = i % 2 == 0 ? random() % 200 : random() % bad.size();
    bad[at] ^= static_cast<std::byte>(1u << (random() % 8));
    const Result<DistanceField> field = baked.unpack(bad);
    refused += field.ok() ? 0 : 1;
    if (!field.ok()) continue;
    for (int k = 0; k < 20; ++k) {
      DistanceField::Triangles near;
      field->read(glm::vec3(unit(random), unit(random), unit(random)), near);
      for (const std::uint32_t t : near) EXPECT_LT(t, baked.mesh.triangles.size());
    }
  }
  EXPECT_GT(refused, 100);
}

/// Real CAD in the folder TANDEM_DATA, some of its meshes of up to 4,000 triangles.
std::vector<Mesh> realMeshes(const char* file, std::size_t step) {
  const char* data = std::getenv("TANDEM_DATA");
  std::vector<Mesh> meshes;
  if (data == nullptr) return meshes;
  assets::LoadOptions load;
  load.unitScale = 0.001;
  auto scene = assets::loadGltf(std::string(data) + "/" + file, load);
  if (!scene.ok()) return meshes;
  for (std::size_t i = 1; i < scene->meshes.size(); i += step)
    if (scene->meshes[i].triangles.size() < 4000) meshes.push_back(std::move(scene->meshes[i]));
  return meshes;
}

/// Most of them lack faces. That their holes are closed must not disagree with the winding number.
TEST(DistanceField, HoldsItsBoundAroundRealCad) {
  const std::vector<Mesh> meshes = realMeshes("2CylinderEngine.glb", 3);
  if (meshes.empty()) GTEST_SKIP() << "TANDEM_DATA is not set";
  for (std::size_t i = 0; i < meshes.size(); ++i) {
    const Baked baked(meshes[i], optionsFor(meshes[i], 20.0, 1e-3));
    const MeshSides sides(baked.tree);
    const WindingTree winding(meshes[i]);
    EXPECT_TRUE(baked.field.solid()) << i;
    EXPECT_LE(attack(
                  baked, [&](const glm::dvec3& p) { return sides.sideAt(p, 0.0).sign; }, 150),
              0.0)
        << "mesh " << i;
    std::mt19937 random(23);
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    for (int k = 0; k < 200; ++k) {
      const assets::Bounds& box = meshes[i].bounds;
      const glm::dvec3 p =
          box.min + glm::dvec3(unit(random), unit(random), unit(random)) * (box.max - box.min);
      const double w = winding.at(p);
      if (std::abs(w - 0.5) < 0.3) continue;
      EXPECT_EQ(w > 0.5 ? -1.0 : 1.0, sides.sideAt(p, 0.0).sign) << "mesh " << i;
    }
  }
}

/// Along a line through many cells, with steps far smaller than they.
TEST(DistanceField, HoldsItsBoundAlongLinesThroughItsCells) {
  const Baked baked(boxMesh({0.03, 0.02, 0.01}));
  const SideOf side = [&](const glm::dvec3& p) { return sideByRays(baked.tree, p); };
  std::mt19937 random(11);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  for (int line = 0; line < 10; ++line) {
    const glm::dvec3 from(0.02 * unit(random), 0.015 * unit(random), 0.01 * unit(random));
    const glm::dvec3 to(0.02 * unit(random), 0.015 * unit(random), 0.01 * unit(random));
    for (int i = 0; i < 1000; ++i)
      EXPECT_LE(excess(baked, glm::vec3(from + 1e-3 * i * (to - from)), side), 0.0) << line << ", " << i;
  }
}

/// A negative control: with half of the error that the cells state, the same attack finds points beyond it.
TEST(DistanceField, StatesNoMuchLargerErrorThanThereIs) {
  const Baked baked(sphereMesh(0.01, 24));
  std::mt19937 random(13);
  std::uniform_real_distribution<float> unit(-1.0f, 1.0f);
  int beyondHalf = 0;
  for (int i = 0; i < 20000; ++i) {
    const glm::vec3 p = 0.01f * glm::normalize(glm::vec3(unit(random), unit(random), unit(random)));
    const auto reading = baked.field.read(p);
    const glm::dvec3 at = glm::dvec3(p) + baked.field.origin();
    const double off =
        std::abs(sideByRays(baked.tree, at) * baked.distance(at) - static_cast<double>(reading.distance));
    beyondHalf += off > 0.5 * static_cast<double>(reading.error) ? 1 : 0;
  }
  EXPECT_GT(beyondHalf, 100);
}

/// Beside edges the nearest triangle is one of a few, and the tree need not be asked. A negative control: a
/// list that lacks one of its triangles is wrong somewhere.
TEST(DistanceField, ListsTheNearestTrianglesBesideEdges) {
  for (const Mesh& mesh : {boxMesh({0.03, 0.02, 0.01}), sphereMesh(0.01, 12)}) {
    const Baked baked(mesh);
    std::mt19937 random(29);
    std::uniform_real_distribution<double> unit(-1.0, 1.0);
    int listed = 0, answers = 0, wrongWithoutOne = 0;
    for (int i = 0; i < 4000; ++i) {
      const auto& t = mesh.triangles[random() % mesh.triangles.size()];
      const double u = 0.5 + 0.5 * unit(random);
      const glm::dvec3 edge = mesh.positions[t[0]] + u * (mesh.positions[t[1]] - mesh.positions[t[0]]),
                       aside(unit(random), unit(random), unit(random));
      const glm::dvec3 at = edge + baked.field.smallestCell() * aside;
      std::vector<std::uint32_t> near = baked.listedAt(glm::vec3(at - baked.field.origin()));
      if (near.empty()) continue;
      ++listed;
      MeshPoint byTree, byList;
      baked.tree.closestPoint(at, 1e300, byTree);
      const bool found = baked.tree.closestPointAmong(near, at, 1e300, byList);
      answers += found && byList.triangle == byTree.triangle && byList.point == byTree.point &&
                         byList.distance == byTree.distance
                     ? 1
                     : 0;
      near.erase(near.begin() + static_cast<std::ptrdiff_t>(random() % near.size()));
      wrongWithoutOne += distanceAmong(mesh, near, at) > 1.01 * byTree.distance ? 1 : 0;
    }
    EXPECT_GT(listed, 1000);
    EXPECT_EQ(answers, listed) << "the same answers as by the tree";
    EXPECT_GT(wrongWithoutOne, 100);
  }
}

TEST(MeshSides, SaysWhatTellsInsideFromOutside) {
  const auto kindOf = [](const Mesh& mesh) {
    const TriangleBvh tree(mesh, 1);
    return MeshSides(tree).kind();
  };
  EXPECT_EQ(kindOf(boxMesh(glm::dvec3(1.0))), MeshSides::Kind::clean);
  EXPECT_EQ(kindOf(overlappingBoxes()), MeshSides::Kind::crossings);
  EXPECT_EQ(kindOf(looseBox(1.0, 1e-3)), MeshSides::Kind::winding);
}

/// A box of 12 n^2 triangles without some of them.
Mesh openBox(std::size_t missing, int n = 1) {
  const assets::TriangleSoup box = test::boxSoup(glm::dvec3(1.0), n);
  test::ShapeBuilder b;
  for (const glm::dvec3& p : box.positions) b.vertex(p.x, p.y, p.z);
  for (std::size_t t = missing; t < box.triangles.size(); ++t)
    b.triangle(box.triangles[t][0], box.triangles[t][1], box.triangles[t][2]);
  return b.mesh();
}

TEST(DistanceField, ClosesWhatABoxLacks) {
  for (const std::size_t missing : {1, 2}) {
    const Baked baked(openBox(missing, 6));
    const Baked whole(boxMesh(glm::dvec3(1.0)));
    ASSERT_TRUE(baked.field.solid()) << missing;
    EXPECT_LT(baked.field.read({0.0f, 0.0f, 0.0f}).distance, -0.2f);
    EXPECT_GT(baked.field.read({0.55f, 0.1f, 0.1f}).distance, 0.0f);
    // The hole is flat, so that closed it is the box; what is missing is no surface, though.
    EXPECT_LE(attack(
                  baked, [&](const glm::dvec3& p) { return sideByRays(whole.tree, p); }, 2000),
              0.0);
  }
}

TEST(DistanceField, HasNoInsideWhereAMouthLeadsIn) {
  for (const std::size_t missing : {1, 2}) {
    const Baked baked(openBox(missing));
    EXPECT_TRUE(MeshSides(baked.tree).hasMouth());
    EXPECT_FALSE(baked.field.solid()) << missing;
    EXPECT_LE(attack(
                  baked, [](const glm::dvec3&) { return 1.0; }, 2000),
              0.0);
  }
  EXPECT_FALSE(MeshSides(Baked(openBox(2, 6)).tree).hasMouth()) << "a defect";
}

TEST(WindingTree, CountsAsExactlyAsTriangleByTriangle) {
  const Mesh mesh = openBox(1);
  const Mesh sphere = sphereMesh(1.0, 40);
  for (const Mesh& m : {mesh, sphere}) {
    const WindingTree tree(m);
    std::mt19937 random(17);
    std::uniform_real_distribution<double> unit(-2.0, 2.0);
    for (int i = 0; i < 300; ++i) {
      const glm::dvec3 p(unit(random), unit(random), unit(random));
      double sum = 0.0;
      for (const auto& t : m.triangles)
        sum += windingOfTriangle(p, {m.positions[t[0]], m.positions[t[1]], m.positions[t[2]]});
      EXPECT_NEAR(tree.at(p), sum, 0.06);
    }
  }
}

TEST(DistanceField, OfNothingIsFarAway) {
  const Baked baked(Mesh{}, {});
  EXPECT_GT(baked.field.read({0.0f, 0.0f, 0.0f}).distance, 1e30f);
  EXPECT_FALSE(baked.field.solid());
}

}  // namespace
}  // namespace tandem::haptics
