// While the tool presses a part, the part's mesh is replaced: tessellated anew, or by another shape.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include <glm/geometric.hpp>

#include "haptics/scene/contact_scene_data.h"
#include "tests/haptics/hard_cases/hard_case.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/bench_meshes.h"

namespace tandem::test {
namespace {

using assets::Mesh;
using tests::Topology;

constexpr double kRadius = 0.05;  // m

/// A box whose upper face is at `top`; in n x n quads a side, split one way or the other.
Mesh boxUpTo(double top, int n = 1, bool turned = false) {
  std::vector<glm::dvec3> positions;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  const glm::dvec3 low(-0.1, -0.1, -0.05), high(0.1, 0.1, top);
  const auto face = [&](int axis, double at, bool outwards) {
    const auto first = static_cast<std::uint32_t>(positions.size()), row = static_cast<std::uint32_t>(n + 1);
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    for (int i = 0; i <= n; ++i) {
      for (int j = 0; j <= n; ++j) {
        glm::dvec3 p(0.0);
        p[axis] = at;
        p[u] = low[u] + (high[u] - low[u]) * i / n;
        p[v] = low[v] + (high[v] - low[v]) * j / n;
        positions.push_back(p);
      }
    }
    for (std::uint32_t i = 0; i + 1 < row; ++i) {
      for (std::uint32_t j = 0; j + 1 < row; ++j) {
        const std::uint32_t a = first + i * row + j, b = a + row, c = b + 1, d = a + 1;
        std::array<std::uint32_t, 3> one = turned ? std::array{a, b, d} : std::array{a, b, c};
        std::array<std::uint32_t, 3> two = turned ? std::array{b, c, d} : std::array{a, c, d};
        if (!outwards) {
          std::swap(one[1], one[2]);
          std::swap(two[1], two[2]);
        }
        triangles.push_back(one);
        triangles.push_back(two);
      }
    }
  };
  for (int axis = 0; axis < 3; ++axis) {
    face(axis, high[axis], true);
    face(axis, low[axis], false);
  }
  return soupMesh(positions, triangles);
}

Mesh sphere(std::size_t triangles) { return tests::sphereMesh(kRadius, triangles, Topology::never); }

/// How far the facets lie inside the sphere at most, m.
double largestSagitta(const Mesh& mesh) {
  haptics::MeshPoint nearest;
  const haptics::TriangleBvh tree(mesh, 1);
  return tree.closestPoint(glm::dvec3(0.0), 1.0, nearest) ? kRadius - nearest.distance : kRadius;
}

/// A hand whose part may change its mesh.
class SwapHand : public ScaledHand {
 public:
  using ScaledHand::ScaledHand;

  void swap(const Mesh& mesh) {
    haptics::ContactScene next =
        probe.contact.withMesh(0, std::make_shared<const Mesh>(scaledMesh(mesh, scale)), 1);
    probe.state.adopt(next);
    probe.contact = std::move(next);  // the one before ends here
  }
  /// The hand stands still for a tick.
  glm::dvec3 rest() { return at(probe.sample.worldFromDevice.position / scale); }

  bool outside() {
    const haptics::ContactWorld& world = probe.state.data().world;
    const glm::dvec3 p = probe.out.worldFromProxy.position;
    haptics::SurfacePoint near;
    const double least = probe.parameters.toolRadius + 0.4 * world.skin(0, p);
    return !world.encloses(0, p) && !world.nearest(0, p, least, near);
  }
  bool namesTrianglesThatExist() {
    const haptics::Proxy& proxy = probe.state.data().tool.proxy();
    for (const haptics::ProxyPlane& plane : proxy.planes) {
      const haptics::SurfacePoint& at = plane.surface;
      if (at.triangle >= probe.state.data().world.collider(at.part).tree->mesh().triangles.size())
        return false;
    }
    return true;
  }
};

void expectRetessellationUnfelt(double toolRadius) {
  const Mesh meshes[] = {sphere(2'000), sphere(20'000), sphere(6'000)};
  const double gap =
      std::max({largestSagitta(meshes[0]), largestSagitta(meshes[1]), largestSagitta(meshes[2])});
  const double reach = kRadius + toolRadius;
  atEveryScale(1e-5, [&](double scale, std::vector<glm::dvec3>& forces) {
    SwapHand hand(sceneOf(meshes[0]), scale, toolRadius);
    const auto place = [&](double angle, double depth) {
      return (reach - depth) * glm::dvec3(std::sin(angle), 0.17 * std::cos(angle), std::cos(angle)) /
             std::sqrt(1.0 + 0.0289 * std::cos(angle) * std::cos(angle));
    };
    hand.to(place(0.3, -0.001), 1e-4);
    hand.to(place(0.3, 0.002), 1e-4);
    for (int i = 0; i < 200; ++i) {
      if (i % 5 == 0) {
        const glm::dvec3 before = hand.rest();
        hand.swap(meshes[i / 5 % 3]);
        const glm::dvec3 after = hand.rest();
        // Depths differ by the sagitta, directions by the angle between facets: sqrt(8 s / R) for edges of s.
        const double turn = 2.0 * std::sqrt(8.0 * gap / kRadius);
        EXPECT_LE(glm::length(after - before), kStiffness * (gap + 0.002 * turn));
        EXPECT_LE(std::abs(glm::length(after) - glm::length(before)), kStiffness * gap);
        EXPECT_NEAR(glm::length(after), kStiffness * 0.002, kStiffness * gap);
      }
      forces.push_back(hand.at(place(0.3 + 0.002 * i, 0.002)));
      ASSERT_TRUE(hand.outside()) << i;
      ASSERT_TRUE(hand.namesTrianglesThatExist());
    }
  });
}

TEST(MeshSwap, PointOnASphereFeelsNoMoreThanTheSagittaOfItsTessellations) { expectRetessellationUnfelt(0.0); }

TEST(MeshSwap, BallOnASphereFeelsNoMoreThanTheSagittaOfItsTessellations) {
  expectRetessellationUnfelt(0.003);
}

TEST(MeshSwap, FlatFaceCutAnewIsFeltAsTheSame) {
  atEveryScale(1e-6, [](double scale, std::vector<glm::dvec3>& forces) {
    SwapHand hand(sceneOf(boxUpTo(0.0)), scale);
    hand.to({0.013, 0.007, 0.001}, 1e-4);
    hand.to({0.013, 0.007, -0.001}, 1e-4);
    for (int i = 1; i < 12; ++i) {
      hand.swap(boxUpTo(0.0, i, i % 2 == 1));
      forces.push_back(hand.rest());
      EXPECT_NEAR(forces.back().z, kStiffness * 0.001, 1e-5);
      EXPECT_NEAR(forces.back().x, 0.0, 1e-5);
      EXPECT_TRUE(hand.outside());
    }
  });
}

TEST(MeshSwap, ToolThatSticksByFrictionGoesOnSticking) {
  atEveryScale(1e-6, [](double scale, std::vector<glm::dvec3>& forces) {
    assets::Scene scene = sceneOf(boxUpTo(0.0));
    scene.materials.resize(1);
    scene.materials[0].staticFriction = 0.5;
    scene.materials[0].dynamicFriction = 0.4;
    SwapHand hand(std::move(scene), scale);
    hand.to({0.013, 0.007, 0.0001}, 1e-4);
    hand.to({0.013, 0.007, -0.001}, 1e-4);
    hand.to({0.0133, 0.007, -0.001}, 1e-4);
    for (int i = 1; i < 6; ++i) {
      hand.swap(boxUpTo(0.0, i, i % 2 == 1));
      forces.push_back(hand.rest());
      EXPECT_NEAR(forces.back().x, -kStiffness * 0.0003, 1e-5);
      EXPECT_NEAR(forces.back().z, kStiffness * 0.001, 1e-5);
    }
  });
}

/// From a box to another shape whose surface over the tool is at `height`: what is felt, ramp and end.
void expectRampTo(const Mesh& shape, double height, double scale, std::vector<glm::dvec3>& forces) {
  SwapHand hand(sceneOf(boxUpTo(0.0)), scale);
  hand.to({0.013, 0.007, 0.001}, 1e-4);
  hand.to({0.013, 0.007, -0.001}, 1e-4);
  hand.probe.parameters.slewLimit = 400.0 * scale;
  hand.rest();
  glm::dvec3 last = hand.rest();
  ASSERT_NEAR(last.z, kStiffness * 0.001, 1e-5);
  hand.swap(shape);
  const double goal = std::max(0.0, kStiffness * (height + 0.001));
  const int ramp = static_cast<int>(std::ceil(std::abs(goal - last.z) / 0.4));
  for (int i = 0; i < ramp + 2; ++i) {
    const glm::dvec3 now = hand.rest();
    EXPECT_LE(glm::length(now - last), 0.4 * (1.0 + 1e-9));
    EXPECT_TRUE(hand.outside()) << i;
    EXPECT_TRUE(hand.namesTrianglesThatExist());
    EXPECT_NEAR(hand.proxy().z, std::max(height, -0.001), 1e-8);
    last = now;
    forces.push_back(now);
  }
  EXPECT_NEAR(last.z, goal, 1e-5);
  EXPECT_EQ(hand.probe.out.flags & haptics::kFlagFault, 0u);
}

TEST(MeshSwap, OtherShapeIsFeltAtItsOwnDepthAfterARampAtTheLimitedRate) {
  for (const double height : {0.004, 0.0005, -0.0004, -0.003}) {
    SCOPED_TRACE(height);
    atEveryScale(1e-5, [&](double scale, std::vector<glm::dvec3>& forces) {
      expectRampTo(boxUpTo(height, 3), height, scale, forces);
    });
  }
}

TEST(MeshSwap, OpenSheetThatTakesThePlaceOfASolidIsFeltFromTheSameSide) {
  for (const double height : {0.002, -0.0003}) {
    Mesh sheet = sheetMesh(0.2, 8);
    for (glm::dvec3& p : sheet.positions) p.z += height;
    SCOPED_TRACE(height);
    atEveryScale(1e-5, [&](double scale, std::vector<glm::dvec3>& forces) {
      expectRampTo(soupMesh(sheet.positions, sheet.triangles), height, scale, forces);
    });
  }
}

TEST(MeshSwap, FarFewerTrianglesLeaveNoIndexOfTheOldOnes) {
  atEveryScale(1e-5, [](double scale, std::vector<glm::dvec3>& forces) {
    Mesh many = sphere(20'000);
    std::reverse(many.triangles.begin(), many.triangles.end());  // so that those on top come last
    SwapHand hand(sceneOf(soupMesh(many.positions, many.triangles)), scale, 0.002);
    hand.to({0.0, 0.001, kRadius + 0.003}, 1e-4);
    hand.to({0.0, 0.001, kRadius + 0.001}, 1e-4);
    ASSERT_GT(hand.probe.out.contactCount, 0);
    hand.swap(boxUpTo(kRadius));
    EXPECT_FALSE(hand.namesTrianglesThatExist());  // so the next tick must not look at them
    const AllocationScope scope;
    const glm::dvec3 force = hand.rest();
    EXPECT_EQ(scope.count(), 0u);
    EXPECT_TRUE(hand.namesTrianglesThatExist());
    EXPECT_NEAR(force.z, kStiffness * 0.001, 1e-5);
    forces.push_back(force);
  });
}

TEST(MeshSwap, ToolInACornerStaysOutOfACornerThatComesCloser) {
  const auto corner = [](double by) {
    Mesh mesh = cornerMesh(0.1);
    for (glm::dvec3& p : mesh.positions) p += by * glm::normalize(glm::dvec3(1.0));
    return mesh;
  };
  atEveryScale(1e-5, [&](double scale, std::vector<glm::dvec3>& forces) {
    SwapHand hand(sceneOf(corner(0.0)), scale);
    hand.to(glm::dvec3(0.01), 1e-3);
    hand.to(glm::dvec3(-0.001), 1e-4);
    ASSERT_EQ(hand.probe.out.contactCount, 3);
    for (const double by : {0.0, 0.0005, 0.002, 0.001}) {
      hand.swap(corner(by));
      for (int i = 0; i < 2; ++i) {
        forces.push_back(hand.rest());
        const double depth = 0.001 + by / std::sqrt(3.0);
        EXPECT_LE(glm::length(forces.back() - kStiffness * glm::dvec3(depth)), 1e-4) << by;
      }
    }
  });
}

TEST(MeshSwap, OfAPartThatIsNotTouchedIsNotFelt) {
  SceneBuilder builder;
  builder.addPart(boxUpTo(0.0));
  const PartId other = builder.addPart(sphere(2'000));
  builder.scene.parts[other].worldFromPart.position = {0.0, 0.0, 0.3};
  HandProbe probe(builder.scene);
  probe.at({0.01, 0.02, 0.001});
  const haptics::TickOutput before = probe.to({0.01, 0.02, -0.001}, 1e-4);
  haptics::ContactScene next =
      probe.contact.withMesh(builder.scene.parts[other].mesh, std::make_shared<const Mesh>(sphere(500)), 1);
  probe.state.adopt(next);
  probe.contact = std::move(next);
  const haptics::TickOutput& after = probe.at({0.01, 0.02, -0.001});
  EXPECT_EQ(after.hands[0].toHand.force, before.hands[0].toHand.force);
  EXPECT_EQ(after.worldFromProxy.position, before.worldFromProxy.position);
}

/// The negative control: geometry exchanged, the proxy not told.
TEST(MeshSwap, WithoutFollowingTheNewMeshTheProxyIsLeftInsideIt) {
  for (const double scale : kScales) {
    SwapHand hand(sceneOf(boxUpTo(0.0)), scale);
    hand.to({0.013, 0.007, 0.001}, 1e-4);
    hand.to({0.013, 0.007, -0.001}, 1e-4);
    hand.swap(boxUpTo(0.004));
    hand.probe.state.data().tool.leaveMeshChange();
    const glm::dvec3 force = hand.rest();
    EXPECT_FALSE(hand.outside());
    EXPECT_GT(std::abs(force.z - kStiffness * 0.005), 1.0);
  }
}

}  // namespace
}  // namespace tandem::test
