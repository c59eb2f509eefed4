// Lower bounds of distances to what a node's children hold, on every node of real trees.

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <random>
#include <vector>

#include <glm/geometric.hpp>

#include "haptics/geometry/near_boxes.h"
#include "tests/support/bench_meshes.h"

namespace tandem::test {
namespace {

using haptics::NearBoxes;
using haptics::TriangleBvh;

/// The distance of p to the nearest triangle below a child, each tested alone, m.
double distanceBelow(const TriangleBvh& tree, std::uint32_t child, const glm::dvec3& p) {
  double least = std::numeric_limits<double>::infinity();
  if (child == TriangleBvh::kEmptyChild) return least;
  if ((child & TriangleBvh::kLeafBit) == 0) {
    for (const std::uint32_t below : tree.nodes()[child].child)
      least = std::min(least, distanceBelow(tree, below, p));
    return least;
  }
  for (std::uint32_t i = 0; i < TriangleBvh::leafCount(child); ++i) {
    const std::uint32_t triangle = tree.leafTriangle((child & TriangleBvh::kLeafFirstMask) + i);
    least = std::min(least, glm::distance(p, closestPointOnTriangle(p, tree.triangle(triangle)).point));
  }
  return least;
}

/// How many of the nodes' bounds are too large, and the mean share of the distance that they reach.
struct Bounds {
  int tooLarge = 0;
  double tightness = 0.0;
};

/// `lift`: added to the height of every slab, in 1/128 of its box's reach.
Bounds boundsOver(const TriangleBvh& tree, const std::vector<glm::dvec3>& places, int lift,
                  bool slabs = true) {
  Bounds result;
  int count = 0;
  for (const glm::dvec3& p : places) {
    const glm::dvec3 q = p - tree.centre();
    const double size = glm::length(tree.bounds().max - tree.bounds().min);
    const NearBoxes near(q, size + glm::length(q));
    for (TriangleBvh::Node node : tree.nodes()) {
      for (std::uint32_t& slab : node.slab) {
        const int height = static_cast<std::int8_t>(slab >> 24) + lift;
        if (slab != 0) slab = (slab & 0xffffffu) | (static_cast<std::uint32_t>(height) & 0xffu) << 24;
        if (!slabs || height < -128) slab = 0;
      }
      alignas(16) float bounds[4];
      const int mask = near.within(node, std::numeric_limits<float>::max(), bounds);
      for (int k = 0; k < 4; ++k) {
        if ((mask >> k & 1) == 0) continue;
        const double truth = distanceBelow(tree, node.child[k], p);
        result.tooLarge += static_cast<double>(bounds[k]) > truth ? 1 : 0;
        if (!(truth > 0.0)) continue;
        result.tightness += std::max(0.0, static_cast<double>(bounds[k])) / truth;
        ++count;
      }
    }
  }
  result.tightness /= count;
  return result;
}

/// Over a surface: a few edges of its triangles away from it, in and out, and farther away.
std::vector<glm::dvec3> placesAround(const TriangleBvh& tree, double edge) {
  std::mt19937 random(4);
  std::vector<glm::dvec3> places;
  for (int i = 0; i < 12; ++i) {
    const auto count = static_cast<unsigned>(tree.mesh().triangles.size());
    const haptics::Triangle t = tree.triangle(static_cast<std::uint32_t>(random() % count));
    const double height = edge * (i % 3 == 0 ? -0.7 : i % 3 == 1 ? 1.5 : 8.0);
    places.push_back((t.a + t.b + t.c) / 3.0 + glm::normalize(areaVector(t)) * height);
  }
  return places;
}

TEST(NearBoxes, BoundDistancesFromBelowOnEveryNode) {
  for (const double scale : {1.0, 1e-3, 20.0}) {
    for (const double noise : {0.0, 0.05, 0.3}) {
      const assets::Mesh mesh = tests::scanMesh(0.05 * scale, 1500, noise, 3);
      const TriangleBvh tree(mesh, 1);
      const std::vector<glm::dvec3> places = placesAround(tree, 0.005 * scale);
      EXPECT_EQ(boundsOver(tree, places, 0).tooLarge, 0) << scale << " " << noise;
      EXPECT_GT(boundsOver(tree, places, -20).tooLarge, 30) << "slabs that lie are found out";
    }
  }
}

TEST(NearBoxes, AreTighterWithSlabsThanWithout) {
  const assets::Mesh mesh = tests::sphereMesh(0.05, 5'000);
  const TriangleBvh tree(mesh, 1);
  const std::vector<glm::dvec3> places = placesAround(tree, 0.002);
  EXPECT_GT(boundsOver(tree, places, 0).tightness, boundsOver(tree, places, 0, false).tightness);
}

}  // namespace
}  // namespace tandem::test
