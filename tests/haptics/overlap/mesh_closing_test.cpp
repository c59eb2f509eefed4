// Sides of meshes with holes: the same from every direction, and uncertain where the holes matter.

#include "haptics/overlap/mesh_closing.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "haptics/geometry/winding_tree.h"
#include "haptics/overlap/mesh_intrusion.h"
#include "haptics/overlap/peak_of_least.h"
#include "tests/support/part_meshes.h"
#include "tests/support/shapes.h"

namespace tandem::test {
namespace {

using haptics::MeshClosing;
using haptics::TriangleBvh;

constexpr double kClosingScales[] = {1e-3, 1.0, 50.0};

/// A ball of radius 1 with every `every`-th face gone, turned and scaled.
assets::Mesh tornBall(std::size_t every, double scale, const glm::dvec3& rotation) {
  assets::TriangleSoup soup = sphereSoup(1.0, 8);
  for (glm::dvec3& p : soup.positions) p = fromRotationVector(rotation) * p * scale;
  std::vector<std::array<std::uint32_t, 3>> kept;
  for (std::size_t t = 0; t < soup.triangles.size(); ++t)
    if (t % every != 0) kept.push_back(soup.triangles[t]);
  soup.triangles = kept;
  soup.triangleMaterial.resize(kept.size());
  return meshOf(soup);
}

double windingNumber(const assets::Mesh& mesh, const glm::dvec3& p) {
  double sum = 0.0;
  for (const auto& t : mesh.triangles)
    sum += haptics::windingOfTriangle(p, {mesh.positions[t[0]], mesh.positions[t[1]], mesh.positions[t[2]]});
  return sum;
}

TEST(MeshClosing, SidesDoNotDependOnTheFrame) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> u(-1.2, 1.2);
  for (const double scale : kClosingScales) {
    int byRays = 0;
    for (int turn = 0; turn < 6; ++turn) {
      const glm::dvec3 rotation(u(random), u(random), u(random));
      const assets::Mesh home = tornBall(9, scale, {}), turned = tornBall(9, scale, rotation);
      const TriangleBvh tree(home, 1), turnedTree(turned, 1);
      const MeshClosing closing(tree), turnedClosing(turnedTree);
      for (int i = 0; i < 200; ++i) {
        const glm::dvec3 p = glm::dvec3(u(random), u(random), u(random)) * scale,
                         q = fromRotationVector(rotation) * p;
        EXPECT_EQ(closing.contains(p), turnedClosing.contains(q)) << i;
        EXPECT_NEAR(closing.lidShare(p), turnedClosing.lidShare(q), 1e-9) << i;
        byRays += haptics::containsPoint(tree, p) != haptics::containsPoint(turnedTree, q) ? 1 : 0;
      }
    }
    EXPECT_GT(byRays, 0) << "control: rays of the mesh's frame see different sides";
  }
}

/// A round pot of radius 1 with a crown of points for a rim: its ears are equally high.
assets::Mesh crownedPot(const glm::dvec3& rotation) {
  constexpr int kSides = 16;
  ShapeBuilder b;
  const auto add = [&](const glm::dvec3& p) {
    const glm::dvec3 at(glm::vec3(fromRotationVector(rotation) * p));  // as a file rounds it
    return b.vertex(at.x, at.y, at.z);
  };
  const std::uint32_t middle = add({0.0, 0.0, -1.0});
  for (int i = 0; i < kSides; ++i) {
    const double angle = 2.0 * kPi * i / kSides, x = std::cos(angle), y = std::sin(angle);
    add({x, y, -1.0});
    add({x, y, i % 2 == 0 ? 0.5 : -0.5});
  }
  for (std::uint32_t i = 0; i < kSides; ++i) {
    const std::uint32_t p = middle + 1 + 2 * i, q = middle + 1 + 2 * ((i + 1) % kSides);
    b.quad(p, q, q + 1, p + 1);
    b.triangle(middle, q, p);
  }
  return b.mesh();
}

TEST(MeshClosing, LidsOfARegularHoleDoNotDependOnTheFrame) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> u(-1.2, 1.2);
  const assets::Mesh home = crownedPot({});
  const TriangleBvh tree(home, 1);
  const MeshClosing closing(tree);
  for (int turn = 0; turn < 20; ++turn) {
    const glm::dvec3 rotation(u(random), u(random), u(random));
    const assets::Mesh turned = crownedPot(rotation);
    const TriangleBvh turnedTree(turned, 1);
    const MeshClosing turnedClosing(turnedTree);
    for (int i = 0; i < 50; ++i) {
      const glm::dvec3 p(u(random), u(random), u(random));
      ASSERT_NEAR(closing.lidShare(p), turnedClosing.lidShare(fromRotationVector(rotation) * p), 1e-4)
          << turn << ' ' << i;
    }
  }
}

TEST(MeshClosing, LidsMakeTheWindingNumberWhole) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> u(-1.2, 1.2);
  const assets::Mesh mesh = tornBall(7, 1.0, {0.3, 0.2, 0.1});
  const TriangleBvh tree(mesh, 1);
  const MeshClosing closing(tree);
  ASSERT_NE(closing.lids(), nullptr);
  for (int i = 0; i < 300; ++i) {
    const glm::dvec3 p(u(random), u(random), u(random));
    const double whole = windingNumber(mesh, p) + closing.lidShare(p);
    EXPECT_NEAR(whole, std::round(whole), 1e-9);
    EXPECT_EQ(closing.contains(p), std::abs(whole) > 0.5) << i;
  }
}

TEST(MeshClosing, ClosedMeshesHaveNoLidsAndSheetsNoInside) {
  const assets::Mesh box = boxMesh(glm::dvec3(1.0)), sheet = sheetMesh(1.0, 3);
  const TriangleBvh tree(box, 1), sheetTree(sheet, 1);
  EXPECT_EQ(MeshClosing(tree).lids(), nullptr);
  EXPECT_TRUE(MeshClosing(tree).contains({0.1, 0.2, 0.3}));
  const MeshClosing closing(sheetTree);
  for (const double z : {-0.1, -1e-3, 1e-3, 0.1}) EXPECT_FALSE(closing.contains({0.1, 0.02, z}));
}

TEST(MeshClosing, IsUncertainOnlyWhereLidsCoverAQuarterOfTheSphere) {
  assets::TriangleSoup soup = boxSoup(glm::dvec3(1.0), 1);
  // The side z = 1/2 is left out.
  std::erase_if(soup.triangles, [&](const auto& t) {
    return soup.positions[t[0]].z + soup.positions[t[1]].z + soup.positions[t[2]].z > 1.4;
  });
  soup.triangleMaterial.resize(soup.triangles.size());
  const assets::Mesh mesh = meshOf(soup);
  const TriangleBvh tree(mesh, 1);
  const MeshClosing closing(tree);
  EXPECT_TRUE(closing.contains({0.0, 0.0, 0.0}));
  EXPECT_NEAR(std::abs(closing.lidShare({0.0, 0.0, 0.0})), 1.0 / 6.0, 1e-12);
  EXPECT_TRUE(closing.isCertain({0.0, 0.0, 0.0}));
  EXPECT_TRUE(closing.contains({0.0, 0.0, 0.45}));
  EXPECT_FALSE(closing.isCertain({0.0, 0.0, 0.45}));
  EXPECT_FALSE(closing.contains({0.0, 0.0, 0.55}));
}

TEST(MeshClosing, ManyLidsAreJudgedLikeFew) {
  std::mt19937 random(6);
  std::uniform_real_distribution<double> u(-1.1, 1.1);
  assets::TriangleSoup soup = sphereSoup(1.0, 24);
  std::vector<std::array<std::uint32_t, 3>> kept;
  for (std::size_t t = 0; t < soup.triangles.size(); ++t)
    if (t % 4 != 0 && soup.positions[soup.triangles[t][0]].z < 0.5) kept.push_back(soup.triangles[t]);
  soup.triangles = kept;
  soup.triangleMaterial.resize(kept.size());
  const assets::Mesh mesh = meshOf(soup);
  const TriangleBvh tree(mesh, 1);
  const MeshClosing closing(tree);
  ASSERT_GT(closing.lids()->mesh().triangles.size(), 200u);
  int certain = 0;
  for (int i = 0; i < 500; ++i) {
    const glm::dvec3 p(u(random), u(random), u(random));
    const double share = closing.lidShare(p);
    const MeshClosing::RoughShare rough = closing.roughLidShare(p);
    EXPECT_NEAR(rough.value, share, 0.6 * rough.error);
    EXPECT_EQ(closing.isCertain(p), std::abs(share) < MeshClosing::kMaxLidShare);
    certain += closing.isCertain(p) ? 1 : 0;
  }
  EXPECT_GT(certain, 50);
  EXPECT_LT(certain, 450);
}

TEST(MeshClosing, ClosesSoupsOfTornTriangles) {
  const assets::Mesh block = rawMeshOf(shattered(boxSoup(glm::dvec3(1.0), 6), 0, 40));
  const TriangleBvh tree(block, 1);
  const MeshClosing closing(tree);
  EXPECT_TRUE(closing.contains({0.1, 0.2, 0.3}));
  EXPECT_TRUE(closing.isCertain({0.1, 0.2, 0.3}));
  EXPECT_FALSE(closing.contains({0.1, 0.2, 0.51}));
}

TEST(PeakOfLeast, IsTheLargestOfManyPlaces) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> u(0.0, 1.0);
  for (int i = 0; i < 300; ++i) {
    std::vector<glm::dvec3> functions(1 + static_cast<std::size_t>(4.0 * u(random)));
    for (glm::dvec3& f : functions) f = {u(random), u(random), u(random)};
    const auto least = [&](const glm::dvec3& shares) {
      double value = 1e300;
      for (const glm::dvec3& f : functions) value = std::min(value, glm::dot(f, shares));
      return value;
    };
    const haptics::Peak peak = haptics::peakOfLeast(functions);
    EXPECT_NEAR(least(peak.shares), peak.value, 1e-15);
    EXPECT_NEAR(peak.shares.x + peak.shares.y + peak.shares.z, 1.0, 1e-12);
    double sampled = 0.0;
    constexpr int kSteps = 60;
    for (int x = 0; x <= kSteps; ++x)
      for (int y = 0; x + y <= kSteps; ++y)
        sampled = std::max(sampled, least(glm::dvec3(x, y, kSteps - x - y) / static_cast<double>(kSteps)));
    EXPECT_LE(sampled, peak.value + 1e-14);
    EXPECT_GE(sampled, peak.value - 2.0 / kSteps);
  }
}

}  // namespace
}  // namespace tandem::test
