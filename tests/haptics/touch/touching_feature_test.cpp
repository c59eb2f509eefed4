#include <gtest/gtest.h>

#include <cmath>

#include "haptics/touch/touching_feature.h"
#include "tests/support/part_meshes.h"
#include "tests/support/shapes.h"

namespace tandem::test {
namespace {

using haptics::MeshEdge;
using haptics::MeshEdges;
using haptics::SampleQuery;
using haptics::TouchingFeature;
using haptics::TouchingPlane;
using haptics::TriangleBvh;

struct Ground {
  explicit Ground(assets::Mesh m) : mesh(std::move(m)), tree(mesh), edges(mesh) {}
  TouchingFeature at(const SampleQuery& sample) const {
    TouchingFeature found;
    EXPECT_TRUE(touchingFeature(tree, edges, sample, 1.0, haptics::kNoTriangle, found));
    return found;
  }
  assets::Mesh mesh;
  TriangleBvh tree;
  MeshEdges edges;
};

SampleQuery corner(const glm::dvec3& point, const glm::dvec3& motion, std::span<const glm::dvec3> normals) {
  SampleQuery sample;
  sample.point = point;
  sample.motion = motion;
  sample.normals = normals;
  return sample;
}

const std::array<glm::dvec3, 3> kDownCorner{glm::normalize(glm::dvec3(1.0, 0.0, -1.0)),
                                            glm::normalize(glm::dvec3(-1.0, 0.5, -1.0)),
                                            glm::normalize(glm::dvec3(-0.2, -1.0, -1.0))};

TEST(MeshEdges, OfABoxAreItsTwelve) {
  const assets::Mesh mesh = boxMesh({0.02, 0.03, 0.04});
  const MeshEdges edges(mesh);
  ASSERT_EQ(edges.count(), 12u);
  for (std::uint32_t e = 0; e < edges.count(); ++e) EXPECT_NEAR(edges.edge(e).angle, 0.5 * kPi, 1e-12);
}

TEST(MeshEdges, OfAGrooveAreOneHollowAndItsBorders) {
  const assets::Mesh mesh = grooveMesh(0.02, 0.7);
  const MeshEdges edges(mesh);
  int hollow = 0, borders = 0;
  for (std::uint32_t e = 0; e < edges.count(); ++e) {
    const MeshEdge edge = edges.edge(e);
    hollow += edge.angle < 0.0 ? 1 : 0;
    borders += edge.triangles[0] == edge.triangles[1] ? 1 : 0;
  }
  EXPECT_EQ(hollow, 1);
  EXPECT_EQ(borders, 6);
}

TEST(MeshEdges, TellConvexFromConcave) {
  for (const assets::Mesh& mesh :
       {grooveMesh(0.02, 0.7), meshOf(boltThreadSoup({})), boxMesh({1.0, 2.0, 3.0})}) {
    const MeshEdges edges(mesh);
    for (std::uint32_t e = 0; e < edges.count(); ++e) {
      const MeshEdge edge = edges.edge(e);
      EXPECT_EQ(edges.isConvex(e), edge.angle > 0.0);
      if (edge.triangles[0] == edge.triangles[1]) continue;
      // The second face falls away from the plane of the first at a convex edge.
      double highest = 0.0;
      for (const std::uint32_t v : mesh.triangles[edge.triangles[1]])
        if (v != edge.ends[0] && v != edge.ends[1])
          highest = glm::dot(edge.normals[0], mesh.positions[v] - edge.a);
      EXPECT_EQ(edges.isConvex(e), highest < 0.0);
    }
  }
}

TEST(MeshEdges, HoldFewBytesBesideTheirLists) {
  const assets::Mesh mesh = sphereMesh(0.01, 64);
  const MeshEdges edges(mesh);
  ASSERT_GE(edges.count(), mesh.triangles.size());
  std::size_t listed = 0;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) listed += edges.around(t).size();
  const std::size_t beside = edges.memory() - listed * sizeof(std::uint32_t);
  // Were ends, faces and normals kept, it would be 28 of a triangle and 32 of an edge.
  EXPECT_LE(beside, 3 * mesh.triangles.size() + 4 * edges.count());
}

TEST(MeshEdges, StandAloneInABoxAndNearEachOtherInAThread) {
  const assets::Mesh box = boxMesh(glm::dvec3(0.02)), sphere = sphereMesh(0.01, 64);
  EXPECT_NEAR(MeshEdges(box).sharpSpacing(0.002), 0.002, 1e-6);
  EXPECT_EQ(MeshEdges(sphere).sharpSpacing(0.002), 0.002) << "none are sharp";
  // Four edges a pitch of 2 mm.
  const assets::Mesh bolt = meshOf(boltThreadSoup({}));
  const double spacing = MeshEdges(bolt).sharpSpacing(0.002);
  EXPECT_GT(spacing, 0.0004);
  EXPECT_LT(spacing, 0.001);
}

TEST(TouchingFeature, OutOfReachOutsideIsHeldOffByItsDistanceAlone) {
  // Beside the top of a box and above it, in front of no face, the planes of its edges have smaller gaps
  // than the distance.
  const Ground ground(boxMesh(glm::dvec3(0.02)));
  SampleQuery sample = corner({0.014, 0.0, 0.013}, {1e-5, 0.0, -2e-4}, kDownCorner);
  EXPECT_LT(ground.at(sample).planes[0].gap, 0.00499) << "the gap of a plane through the box";
  sample.outside = true;
  const TouchingFeature found = ground.at(sample);
  ASSERT_EQ(found.count, 1);
  EXPECT_NEAR(found.planes[0].gap, 0.005, 1e-12);
  EXPECT_NEAR(glm::length(found.planes[0].normal - glm::dvec3(0.8, 0.0, 0.6)), 0.0, 1e-12);
}

TEST(TouchingFeature, APlaneThatEndsBeforeTheSampleIsNone) {
  // A low wall that leans over a wide floor: far out on the floor a sample is behind its plane, and touches
  // nothing.
  ShapeBuilder b;
  const auto quad = [&](std::array<glm::dvec3, 4> c) {
    std::array<std::uint32_t, 4> v{};
    for (std::size_t i = 0; i < 4; ++i) v[i] = b.vertex(c[i].x, c[i].y, c[i].z);
    b.quad(v[0], v[1], v[2], v[3]);
  };
  const double y = 0.01;
  const glm::dvec3 top(0.87e-3, 0.0, 0.5e-3), aside(0.0, y, 0.0);
  quad({{{0.0, -y, 0.0}, {0.01, -y, 0.0}, {0.01, y, 0.0}, {0.0, y, 0.0}}});
  quad({{{0.0, -y, 0.0}, {0.0, y, 0.0}, top + aside, top - aside}});
  const Ground ground(b.mesh());
  const glm::dvec3 down(0.0, 0.0, -5e-3);
  const auto near = ground.at(corner({0.6e-3, 0.0, 0.1e-3}, down, kDownCorner));
  EXPECT_EQ(near.count, 2) << "between both, both hold";
  const auto far = ground.at(corner({4e-3, 0.0, 3e-3}, down, kDownCorner));
  ASSERT_EQ(far.count, 1);
  EXPECT_NEAR(far.planes[0].gap, 3e-3, 1e-12);
}

TEST(TouchingFeature, OverAFaceIsItsPlane) {
  const Ground ground(boxMesh(glm::dvec3(0.02)));
  for (const double height : {1e-4, 1e-7, -1e-6}) {
    const auto found = ground.at(corner({0.003, -0.002, 0.01 + height}, {1e-5, 0.0, -2e-4}, kDownCorner));
    ASSERT_EQ(found.count, 1);
    EXPECT_NEAR(found.planes[0].gap, height, 1e-15);
    EXPECT_NEAR(found.planes[0].normal.z, 1.0, 1e-12);
  }
}

TEST(TouchingFeature, InAHollowIsBothPlanes) {
  const Ground ground(cornerMesh(0.02));
  const auto found = ground.at(corner({1e-5, 5e-3, 2e-5}, {-1e-4, 0.0, -1e-4}, kDownCorner));
  ASSERT_EQ(found.count, 2);
  EXPECT_NEAR(found.planes[0].normal.x, 1.0, 1e-12);
  EXPECT_NEAR(found.planes[0].gap, 1e-5, 1e-15);
  EXPECT_NEAR(found.planes[1].normal.z, 1.0, 1e-12);
  EXPECT_NEAR(found.planes[1].gap, 2e-5, 1e-15);
}

TEST(TouchingFeature, BesideARimItTakesThePlaneThatLetsTheMotionPass) {
  // A corner just beside the top edge of a box, going down past it: the side face parts them; the top would
  // hold it up on nothing.
  const Ground ground(boxMesh(glm::dvec3(0.02)));
  const std::array<glm::dvec3, 2> normals{glm::dvec3(-1.0, 0.0, 0.0), glm::dvec3(0.0, 0.0, -1.0)};
  const auto found = ground.at(corner({0.01 + 2e-6, 0.0, 0.01 + 1e-6}, {0.0, 0.0, -1e-4}, normals));
  EXPECT_NEAR(found.planes[0].normal.x, 1.0, 1e-3);
  EXPECT_GE(found.planes[0].gap, 0.0);
  // The same corner that moves inwards over the top has the top's normal.
  const auto above = ground.at(corner({0.01 + 2e-6, 0.0, 0.01 + 1e-6}, {-1e-4, 0.0, -1e-7}, normals));
  EXPECT_GT(above.planes[0].normal.z, 0.9);
}

TEST(TouchingFeature, OfCrossingEdgesIsNormalToBoth) {
  const Ground ground(boxMesh(glm::dvec3(0.02)));
  // An edge of another body over the top edge along y: it runs along x, sloping down outwards.
  const glm::dvec3 along = glm::normalize(glm::dvec3(1.0, 0.0, -1.0));
  const std::array<glm::dvec3, 2> normals{glm::normalize(glm::dvec3(-1.0, 1.0, -1.0)),
                                          glm::normalize(glm::dvec3(-1.0, -1.0, -1.0))};
  const glm::dvec3 crossing =
      glm::dvec3(0.01, 0.001, 0.01) + 3e-6 * glm::normalize(glm::dvec3(1.0, 0.0, 1.0));
  SampleQuery sample = corner(crossing + 2e-4 * along, {0.0, 0.0, -1e-4}, normals);
  sample.edge = along;
  sample.along = 3e-4;
  const auto found = ground.at(sample);
  EXPECT_NEAR(found.planes[0].gap, 3e-6, 1e-12);
  EXPECT_LT(glm::length(found.planes[0].normal - glm::normalize(glm::dvec3(1.0, 0.0, 1.0))), 1e-9);
  EXPECT_LT(glm::length(found.planes[0].point - crossing), 1e-9);
}

TEST(TouchingFeature, OfEdgesThatCrossAtTheEndOfTheMotionIsNormalToBoth) {
  const Ground ground(boxMesh(glm::dvec3(0.02)));
  const glm::dvec3 along = glm::normalize(glm::dvec3(1.0, 0.0, -1.0));
  const std::array<glm::dvec3, 2> normals{glm::normalize(glm::dvec3(-1.0, 1.0, -1.0)),
                                          glm::normalize(glm::dvec3(-1.0, -1.0, -1.0))};
  // The edge of above ends 20 um before the box's edge, and is moved along itself over it or back.
  const glm::dvec3 over = glm::dvec3(0.01, 0.001, 0.01) + 3e-6 * glm::normalize(glm::dvec3(1.0, 0.0, 1.0));
  const auto gapAfter = [&](double motion) {
    SampleQuery sample = corner(over - 3.2e-4 * along, motion * along, normals);
    sample.edge = along;
    sample.along = 3e-4;
    const TouchingPlane plane = ground.at(sample).planes[0];
    return glm::length(plane.normal - glm::normalize(glm::dvec3(1.0, 0.0, 1.0))) < 1e-9 ? plane.gap : 1.0;
  };
  EXPECT_NEAR(gapAfter(4e-5), 3e-6, 1e-12);
  EXPECT_EQ(gapAfter(-4e-5), 1.0);
}

TEST(TouchingFeature, AtTheMouthOfAHollowCornerBothPlanesAreNormalToTheEdgeThatLeavesIt) {
  // An edge of a peg that leans in a corner of its bore, where both walls end at the top.
  const Ground ground(meshOf(boredBlockSoup({0.01, 0.045, 0.03, 0.045, 0.0, Fit::around, {24, 1}})));
  const double wide = 0.01 / std::cos(kPi / 24.0), lean = 0.0145;
  const auto at = [](double degrees) {
    const double a = degrees * kPi / 180.0;
    return glm::dvec3(std::cos(a), std::sin(a), 0.0);
  };
  const glm::dvec3 outwards = at(30.0), edge = glm::normalize(glm::dvec3(0.0, 0.0, 1.0) + lean * outwards);
  const auto across = [&](const glm::dvec3& n) { return glm::normalize(n - edge * glm::dot(edge, n)); };
  const std::array<glm::dvec3, 2> normals{across(at(22.0)), across(at(38.0))};
  SampleQuery sample = corner((wide - 1e-8) * outwards, 1e-5 * outwards, normals);
  sample.edge = edge;
  sample.along = 1e-3;
  const TouchingFeature found = ground.at(sample);
  ASSERT_EQ(found.count, 2);
  for (std::size_t k = 0; k < 2; ++k) EXPECT_LT(std::abs(glm::dot(found.planes[k].normal, edge)), 1e-9) << k;
  EXPECT_LT(glm::dot(found.planes[0].normal, found.planes[1].normal), std::cos(0.9 * kPi / 12.0));
}

TEST(TouchingFeature, OutOfReachIsNone) {
  const Ground ground(boxMesh(glm::dvec3(0.02)));
  TouchingFeature found;
  EXPECT_FALSE(touchingFeature(ground.tree, ground.edges, corner({0.0, 0.0, 0.05}, {}, kDownCorner), 0.01,
                               haptics::kNoTriangle, found));
}

TEST(TouchingFeature, ScalesWithTheGeometry) {
  for (const double scale : {1e-3, 20.0}) {
    const Ground one(boxMesh(glm::dvec3(0.02))), other(boxMesh(scale * glm::dvec3(0.02)));
    for (int i = 0; i < 50; ++i) {
      const glm::dvec3 p(0.01 + 1e-5 * std::sin(3.0 * i), 0.008 * std::sin(1.7 * i),
                         0.01 + 1e-5 * std::cos(5.0 * i));
      const glm::dvec3 m(1e-5 * std::cos(1.0 * i), 0.0, -1e-5);
      const auto a = one.at(corner(p, m, kDownCorner)),
                 b = other.at(corner(scale * p, scale * m, kDownCorner));
      EXPECT_NEAR(b.planes[0].gap, scale * a.planes[0].gap, 1e-9 * scale * 0.02);
      EXPECT_LT(glm::length(a.planes[0].normal - b.planes[0].normal), 1e-6);
    }
  }
}

}  // namespace
}  // namespace tandem::test
