// The tree's filters must never change an answer: nearest points and swept balls are compared with every
// triangle tested alone, on the geometry that is hardest on them.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include <glm/geometric.hpp>

#include "haptics/geometry/triangle_bvh.h"
#include "tests/support/bench_meshes.h"

namespace tandem::test {
namespace {

using haptics::BallHit;
using haptics::MeshBallHit;
using haptics::MeshPoint;
using haptics::Triangle;
using haptics::TriangleBvh;

struct Soup {
  assets::Mesh mesh;
  void add(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    for (const glm::dvec3& p : {a, b, c}) mesh.positions.push_back(p);
    mesh.triangles.push_back({first, first + 1, first + 2});
  }
};

/// Triangles without area, slivers of 1 : 1e4, duplicates, flipped duplicates, and ordinary ones, within 1 m.
assets::Mesh dirtySoup(int count) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> u(-1.0, 1.0);
  const auto some = [&] { return glm::dvec3(u(random), u(random), u(random)); };
  Soup soup;
  for (int i = 0; i < count; ++i) {
    const double size = std::pow(10.0, -1.5 + u(random));
    const glm::dvec3 a = some(), b = a + size * some(), c = a + size * some();
    if (i % 5 == 0) {
      soup.add(a, b, i % 10 == 0 ? b : a + 0.3 * (b - a));
    } else if (i % 5 == 1) {
      soup.add(a, b, a + 0.5 * (b - a) + 1e-4 * (c - a));
    } else {
      soup.add(a, b, c);
      if (i % 5 == 2) soup.add(a, b, c);
      if (i % 5 == 3) soup.add(c, b, a);
    }
  }
  return soup.mesh;
}

assets::Mesh transformed(assets::Mesh mesh, double scale, const glm::dvec3& offset) {
  for (glm::dvec3& p : mesh.positions) p = p * scale + offset;
  return mesh;
}

/// What every query below runs on: a mesh within 1 m, then scaled and moved.
struct Case {
  std::string name;
  assets::Mesh mesh;
  double scale;
  glm::dvec3 offset;
};

std::vector<Case> cases() {
  const assets::Mesh soup = dirtySoup(700), sphere = tests::sphereMesh(0.9, 6000, tests::Topology::never);
  const assets::Mesh gear = transformed(tests::gearMesh(3000, tests::Topology::never), 40.0, glm::dvec3(0.0));
  std::vector<Case> all;
  for (const double scale : {1e-3, 1.0, 20.0}) {
    for (const glm::dvec3& offset : {glm::dvec3(0.0), glm::dvec3(1e5, -2e5, 3e4)}) {
      if (offset != glm::dvec3(0.0) && scale < 1.0) continue;  // below the rounding of such coordinates
      all.push_back({"soup", transformed(soup, scale, offset), scale, offset});
      all.push_back({"sphere", transformed(sphere, scale, offset), scale, offset});
      all.push_back({"gear", transformed(gear, scale, offset), scale, offset});
    }
  }
  return all;
}

TEST(TriangleBvhExact, ClosestPointIsThatOfEveryTriangleTestedAlone) {
  for (const Case& c : cases()) {
    const TriangleBvh tree(c.mesh, 2);
    std::mt19937 random(1);
    std::uniform_real_distribution<double> u(-1.0, 1.0);
    for (int i = 0; i < 40; ++i) {
      glm::dvec3 p = c.offset + c.scale * 1.2 * glm::dvec3(u(random), u(random), u(random));
      if (i % 3 == 0)
        p = tree.triangle(random() % c.mesh.triangles.size()).a + c.scale * 1e-9 * (p - c.offset);
      double expected = 1e300;
      for (std::uint32_t t = 0; t < c.mesh.triangles.size(); ++t) {
        const glm::dvec3 d = p - haptics::closestPointOnTriangle(p, tree.triangle(t)).point;
        expected = std::min(expected, glm::dot(d, d));
      }
      MeshPoint found;
      ASSERT_TRUE(tree.closestPoint(p, 10.0 * c.scale, found));
      ASSERT_EQ(found.distance, std::sqrt(expected)) << c.name << " " << c.scale << " " << i;
    }
  }
}

/// First touch by testing every triangle alone.
bool sweepAll(const TriangleBvh& tree, const glm::dvec3& from, const glm::dvec3& motion, double radius,
              double tolerance, BallHit& hit) {
  bool found = false;
  for (std::uint32_t t = 0; t < tree.mesh().triangles.size(); ++t) {
    BallHit one;
    one.t = hit.t;
    if (!haptics::sweepBall(from, motion, radius, tolerance, tree.triangle(t), one)) continue;
    hit = one;
    found = true;
  }
  return found;
}

TEST(TriangleBvhExact, SweptBallIsThatOfEveryTriangleTestedAlone) {
  int hits = 0, misses = 0;
  for (const Case& c : cases()) {
    const TriangleBvh tree(c.mesh, 2);
    const double skin = 0x1p-30 * c.scale + 0x1p-42 * glm::length(c.offset);
    std::mt19937 random(2);
    std::uniform_real_distribution<double> u(-1.0, 1.0);
    for (int i = 0; i < 40; ++i) {
      // From a point tool to a ball that spans a hundred triangles.
      const double radius = c.scale * (i % 4 == 0   ? 0.0
                                       : i % 4 == 1 ? 1e-3
                                       : i % 4 == 2 ? 0.05
                                                    : 0.4) +
                            0.5 * skin;
      glm::dvec3 from = c.offset + c.scale * 1.5 * glm::dvec3(u(random), u(random), u(random));
      const glm::dvec3 direction(u(random), u(random), i % 7 == 0 ? 0.0 : u(random));
      glm::dvec3 motion = c.scale * (i % 3 == 0 ? 0.02 : 1.0) * direction;
      if (i % 2 == 0) {
        // Resting on the surface, as a tool in contact does, and sliding along it or a little into it.
        MeshPoint near;
        ASSERT_TRUE(tree.closestPoint(from, 10.0 * c.scale, near));
        const glm::dvec3 normal = (from - near.point) / near.distance;
        if (near.distance < radius) continue;
        from = near.point + normal * (radius + 0.5 * skin);
        motion -= normal * (glm::dot(motion, normal) + (i % 6 == 0 ? 0.0 : 1e-3 * glm::length(motion)));
      }
      BallHit expected;
      MeshBallHit hit;
      const bool any = sweepAll(tree, from, motion, radius, 0.125 * skin, expected);
      ASSERT_EQ(tree.sweepBall(from, motion, radius, 0.125 * skin, hit), any)
          << c.name << " " << c.scale << " " << i;
      if (any) {
        ASSERT_EQ(hit.t, expected.t) << c.name << " " << c.scale << " " << i;
      }
      (any ? hits : misses) += 1;
    }
  }
  EXPECT_GT(hits, 100);
  EXPECT_GT(misses, 100);
}

TEST(TriangleMath, BallThatGrazesIsDecidedWithoutCreeping) {
  // A ball slides along a plane, one skin off; the triangles ahead of it lie in that plane. None may stop it,
  // though it comes as near to each as to the one under it. A skin less, and each must.
  const double radius = 0.5, skin = 1e-9;
  const Triangle ahead{{1.0, -0.1, 0.0}, {1.2, 0.0, 0.0}, {1.0, 0.1, 0.0}};
  const glm::dvec3 motion(3.0, 0.01, 0.0);
  BallHit hit;
  EXPECT_FALSE(
      haptics::sweepBall({0.0, 0.0, radius + skin}, motion, radius + 0.5 * skin, 0.125 * skin, ahead, hit));
  EXPECT_EQ(hit.t, 1.0);
  ASSERT_TRUE(haptics::sweepBall({0.0, 0.0, radius - skin}, motion, radius, 0.125 * skin, ahead, hit));
  // The nearest edge point is (1, y): the ball stops where it is between radius and radius + tolerance away.
  EXPECT_LE(3.0 * hit.t, 1.0 - std::sqrt(2.0 * radius * skin) + 1e-9);
  EXPECT_GE(3.0 * hit.t, 1.0 - std::sqrt(2.0 * radius * 1.125 * skin) - 1e-9);
}

TEST(TriangleMath, SweptBallNeverPassesTheFirstTouchOfACloseGraze) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> u(-1.0, 1.0);
  const Triangle t{{0.0, -0.3, 0.0}, {0.4, 0.1, 0.05}, {-0.3, 0.2, -0.02}};
  int hits = 0, misses = 0;
  for (int i = 0; i < 4000; ++i) {
    // The ball passes the triangle at a distance within a millionth of its radius.
    const double radius = 0.2;
    const glm::dvec3 q = t.a + (0.5 + 0.6 * u(random)) * (t.b - t.a) + (0.3 + 0.5 * u(random)) * (t.c - t.a);
    const glm::dvec3 p = q + glm::dvec3(u(random), u(random), u(random));
    const glm::dvec3 nearest = haptics::closestPointOnTriangle(p, t).point, n = glm::normalize(p - nearest);
    const glm::dvec3 direction = glm::cross(n, glm::dvec3(u(random), u(random), u(random)));
    const glm::dvec3 middle = nearest + n * radius * (1.0 + 1e-6 * u(random));
    const glm::dvec3 from = middle - direction, motion = 2.0 * direction;
    const auto gapAt = [&](double s) {
      const glm::dvec3 x = from + motion * s;
      return glm::length(x - haptics::closestPointOnTriangle(x, t).point) - radius;
    };
    if (gapAt(0.0) <= 1e-9) continue;
    BallHit hit;
    const bool found = haptics::sweepBall(from, motion, radius, 1e-9, t, hit);
    (found ? hits : misses) += 1;
    for (int k = 0; k <= 50; ++k) ASSERT_GE(gapAt((found ? hit.t : 1.0) * k / 50.0), -1e-12) << i;
    if (found) {
      ASSERT_LE(gapAt(hit.t), 1e-9 + 1e-12);
    }
  }
  EXPECT_GT(hits, 500);
  EXPECT_GT(misses, 500);
}

}  // namespace
}  // namespace tandem::test
