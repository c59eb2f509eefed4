#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "haptics/tick_data.h"
#include "tests/haptics/hand_probe.h"

namespace tandem::test {
namespace {

using haptics::TickOutput;

assets::Scene sceneOf(assets::Mesh mesh) {
  SceneBuilder b;
  b.addPart(std::move(mesh));
  return b.scene;
}

void expectNear(const glm::dvec3& actual, const glm::dvec3& expected, double tolerance) {
  EXPECT_NEAR(actual.x, expected.x, tolerance);
  EXPECT_NEAR(actual.y, expected.y, tolerance);
  EXPECT_NEAR(actual.z, expected.z, tolerance);
}

TEST(Proxy, StaysOnSurfaceWhenDevicePenetrates) {
  HandProbe hand(sceneOf(boxMesh({0.1, 0.1, 0.02})));
  hand.at({0.003, 0.002, 0.02});
  EXPECT_EQ(hand.out.hands[0].toHand.force, glm::dvec3(0.0));
  hand.to({0.003, 0.002, 0.008}, 5e-4);
  expectNear(hand.out.worldFromProxy.position, {0.003, 0.002, 0.01}, 1e-9);
  expectNear(hand.out.hands[0].toHand.force, {0.0, 0.0, 800.0 * 0.002}, 1e-6);
  ASSERT_EQ(hand.out.contactCount, 1);
  EXPECT_EQ(hand.out.contacts[0].part, 0);
  EXPECT_EQ(hand.out.touched, 0);
  expectNear(hand.out.contacts[0].normal, {0.0, 0.0, 1.0}, 1e-9);
  hand.to({0.003, 0.002, 0.02}, 5e-4);
  EXPECT_EQ(hand.out.hands[0].toHand.force, glm::dvec3(0.0));
}

TEST(Proxy, HoldsForceConstantWhileSlidingOverPlane) {
  for (const double radius : {0.0, 0.0015}) {
    HandProbe hand(sceneOf(sheetMesh(0.2, 40)));
    hand.parameters.toolRadius = radius;
    hand.at({-0.05, 0.0123, 0.01});
    hand.to({-0.05, 0.0123, radius - 0.002}, 1e-4);
    double worst = 0.0;
    for (int i = 0; i <= 1000; ++i) {  // 0.1 m/s
      hand.at({-0.05 + 1e-4 * i, 0.0123 + 0.3e-4 * i, radius - 0.002});
      worst = std::max(worst, glm::length(hand.out.hands[0].toHand.force - glm::dvec3(0.0, 0.0, 1.6)));
    }
    EXPECT_LT(worst, 1e-5) << "radius " << radius;
  }
}

TEST(Proxy, ReachesTheApexOfAGroove) {
  for (const double degrees : {75.0, 45.0, 15.0, 5.0, 0.5}) {
    HandProbe hand(sceneOf(grooveMesh(0.05, degrees * kPi / 180.0)));
    hand.at({0.0, 0.001, 0.03});
    hand.to({0.0, 0.001, -0.002}, 3e-4);
    hand.to({1e-5, 0.004, -0.002}, 3e-4);
    EXPECT_EQ(hand.out.contactCount, 2) << degrees;
    expectNear(hand.out.worldFromProxy.position, {0.0, 0.004, 0.0}, 2e-8);
    expectNear(hand.out.hands[0].toHand.force, 800.0 * glm::dvec3(-1e-5, 0.0, 0.002), 2e-5);
  }
}

TEST(Proxy, HoldsInATrihedralCorner) {
  HandProbe hand(sceneOf(cornerMesh(0.05)));
  hand.at({0.01, 0.012, 0.013});
  hand.to({-0.001, -0.002, -0.003}, 4e-4);
  EXPECT_EQ(hand.out.contactCount, 3);
  expectNear(hand.out.worldFromProxy.position, {0.0, 0.0, 0.0}, 1e-9);
  expectNear(hand.out.hands[0].toHand.force, {0.8, 1.6, 2.4}, 1e-6);
  double sum = 0.0;
  for (int i = 0; i < 3; ++i) sum += hand.out.contacts[static_cast<std::size_t>(i)].force;
  EXPECT_NEAR(sum, 0.8 + 1.6 + 2.4, 1e-6);
}

TEST(Proxy, ReachesAllPlanesInTheTickOfArrival) {
  HandProbe hand(sceneOf(cornerMesh(0.05)));
  hand.at({0.002, 0.001, 0.003});
  hand.at({-0.001, -0.001, -0.001});
  EXPECT_EQ(hand.out.contactCount, 3);
  expectNear(hand.out.hands[0].toHand.force, {0.8, 0.8, 0.8}, 1e-6);
}

TEST(Proxy, BallRestsAtItsRadiusOverFacesEdgesAndCorners) {
  HandProbe hand(sceneOf(boxMesh({0.04, 0.04, 0.04})));
  hand.parameters.toolRadius = 0.003;
  hand.at({0.0, 0.0, 0.05});
  hand.to({0.001, 0.001, 0.022}, 3e-4);
  expectNear(hand.out.hands[0].toHand.force, {0.0, 0.0, 800.0 * 0.001}, 1e-6);

  HandProbe edge(sceneOf(boxMesh({0.04, 0.04, 0.04})));
  edge.parameters.toolRadius = 0.003;
  edge.at({0.04, 0.001, 0.04});
  edge.to({0.021, 0.001, 0.021}, 3e-4);
  const double depth = 0.003 - std::sqrt(2.0) * 0.001;
  expectNear(edge.out.hands[0].toHand.force, 800.0 * depth / std::sqrt(2.0) * glm::dvec3(1.0, 0.0, 1.0),
             1e-5);

  HandProbe corner(sceneOf(boxMesh({0.04, 0.04, 0.04})));
  corner.parameters.toolRadius = 0.003;
  corner.at({0.04, 0.04, 0.04});
  corner.to({0.021, 0.021, 0.021}, 3e-4);
  const double deep = 0.003 - std::sqrt(3.0) * 0.001;
  expectNear(corner.out.hands[0].toHand.force, 800.0 * deep / std::sqrt(3.0) * glm::dvec3(1.0), 1e-5);
}

TEST(Proxy, PressesAgainstASphereWithinItsSagitta) {
  const double r = 0.05, k = 800.0;
  HandProbe hand(sceneOf(sphereMesh(r, 100)));
  const double sagitta = r * (1.0 - std::cos(kPi / 200.0));
  hand.at({0.0, 0.0, 0.06});
  for (int i = 0; i <= 400; ++i) {
    const double a = 0.002 * i;
    const glm::dvec3 n(std::sin(a), 0.2 * std::sin(a), std::cos(a));
    hand.at(glm::normalize(n) * (r - 0.002));
    const double force = glm::length(hand.out.hands[0].toHand.force);
    EXPECT_LE(force, k * (0.002 + sagitta));
    EXPECT_GE(force, k * (0.002 - 2.0 * sagitta));
  }
}

TEST(Proxy, NeverFallsThroughThinPlates) {
  for (const double thickness : {0.5e-3, 1e-5, 0.0}) {
    SceneBuilder b;
    b.addPart(thickness > 0.0 ? boxMesh({0.1, 0.1, thickness}) : sheetMesh(0.1, 7));
    HandProbe hand(b.scene);
    hand.at({0.011, 0.007, 0.02});
    hand.to({0.011, 0.007, -0.02}, 5e-3);  // 5 m/s
    EXPECT_GT(hand.out.worldFromProxy.position.z, 0.5 * thickness) << thickness;
    hand.to({-0.02, 0.0131, -0.02}, 1e-3);
    EXPECT_GT(hand.out.worldFromProxy.position.z, 0.5 * thickness) << thickness;
    hand.to({-0.02, 0.0131, 0.02}, 5e-3);
    expectNear(hand.out.worldFromProxy.position, {-0.02, 0.0131, 0.02}, 1e-12);
    EXPECT_EQ(hand.out.hands[0].toHand.force, glm::dvec3(0.0));
  }
}

TEST(Proxy, NeverLeaksThroughEdgesAndVerticesOfASoup) {
  // A lattice of triangles that share no vertices, entered exactly at every edge and vertex of the lattice.
  assets::Mesh sheet = sheetMesh(0.08, 8);
  ShapeBuilder soup;
  for (const auto& t : sheet.triangles) {
    std::uint32_t v[3];
    for (int i = 0; i < 3; ++i) {
      const glm::dvec3& p = sheet.positions[t[static_cast<std::size_t>(i)]];
      v[i] = soup.vertex(p.x, p.y, p.z);
    }
    soup.triangle(v[0], v[1], v[2]);
  }
  SceneBuilder b;
  assets::Mesh mesh;
  mesh.positions = soup.soup.positions;
  mesh.triangles = soup.soup.triangles;
  mesh.triangleMaterial = soup.soup.triangleMaterial;
  mesh.bounds = sheet.bounds;
  b.addPart(std::move(mesh));
  for (int i = -7; i <= 7; ++i) {
    for (int j = -7; j <= 7; ++j) {
      HandProbe hand(b.scene);
      const glm::dvec3 at(0.005 * i, 0.005 * j, 0.0);
      hand.at(at + glm::dvec3(0.0, 0.0, 0.01));
      hand.at(at);  // exactly on the lattice
      hand.at(at - glm::dvec3(0.0, 0.0, 0.003));
      EXPECT_NEAR(hand.out.hands[0].toHand.force.z, 2.4, 1e-5) << i << ' ' << j;
      hand.at(at - glm::dvec3(0.001, 0.002, 0.003));
      EXPECT_NEAR(hand.out.hands[0].toHand.force.z, 2.4, 1e-5) << i << ' ' << j;
    }
  }
}

TEST(Proxy, StaysOutOfASphereUnderRandomPushes) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> coordinate(-1.0, 1.0);
  SceneBuilder b;
  b.addPart(sphereMesh(0.02, 24));
  const double inner = 0.02 * std::pow(std::cos(kPi / 48.0), 2.0);
  for (const double radius : {0.0, 0.001}) {
    HandProbe hand(b.scene);
    hand.parameters.toolRadius = radius;
    hand.at({0.03, 0.0, 0.0});
    for (int i = 0; i < 20'000; ++i) {
      const glm::dvec3 goal = 0.025 * glm::dvec3(coordinate(random), coordinate(random), coordinate(random));
      hand.at(goal);
      ASSERT_GT(glm::length(hand.out.worldFromProxy.position), inner + radius * 0.9) << "push " << i;
    }
  }
}

TEST(Proxy, KeepsItsDistanceFromEveryTriangleOfADirtySoup) {
  // Triangles that cross each other at random, slivers and faces without area among them.
  std::mt19937 random(11);
  std::uniform_real_distribution<double> u(-1.0, 1.0);
  assets::Mesh mesh;
  for (std::uint32_t i = 0; i < 300; ++i) {
    const glm::dvec3 a = 0.03 * glm::dvec3(u(random), u(random), u(random));
    const glm::dvec3 ab = 0.02 * glm::dvec3(u(random), u(random), u(random));
    const glm::dvec3 ac =
        i % 5 == 0 ? 0.5 * ab : glm::dvec3(0.02 * u(random), 0.02 * u(random), 0.02 * u(random));
    mesh.positions.insert(mesh.positions.end(), {a, a + ab, a + (i % 7 == 0 ? ab + 1e-4 * ac : ac)});
    mesh.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  for (const double radius : {0.0, 0.001}) {
    HandProbe hand(sceneOf(mesh));
    hand.parameters.toolRadius = radius;
    hand.at({0.06, 0.06, 0.06});
    int touching = 0;
    for (int visit = 0; visit < 100; ++visit) {
      const glm::dvec3 from = hand.sample.worldFromDevice.position;
      const glm::dvec3 to = 0.04 * glm::dvec3(u(random), u(random), u(random));
      for (int i = 1; i <= 50; ++i) {
        hand.at(glm::mix(from, to, i / 50.0));
        touching += hand.out.contactCount > 0 ? 1 : 0;
        const haptics::ContactWorld& world = hand.state.data().world;
        const glm::dvec3& p = hand.out.worldFromProxy.position;
        const double skin = world.skin(0, p);
        haptics::SurfacePoint near;
        if (!world.nearest(0, p, radius + skin, near)) continue;
        ASSERT_GT(glm::length(p - near.point), radius + 0.45 * skin) << visit << ' ' << i;
      }
    }
    EXPECT_GT(touching, 500);
  }
}

TEST(Proxy, ScalesWithTheScene) {
  // The same contact in a scene of millimetres, metres and 20 m: forces scale with lengths.
  for (const double scale : {1e-3, 1.0, 20.0}) {
    HandProbe hand(sceneOf(grooveMesh(0.05 * scale, 0.5)));
    hand.at(scale * glm::dvec3(0.002, 0.0, 0.03));
    hand.to(scale * glm::dvec3(0.002, 0.001, -0.003), 3e-4 * scale);
    // The goal is nearer to the right wall: it alone presses unless the apex is deeper for both.
    const glm::dvec3 force = hand.out.hands[0].toHand.force / scale;
    expectNear(force, 800.0 * glm::dvec3(-0.002, 0.0, 0.003), 1e-5);
  }
}

TEST(Proxy, FrictionHoldsInsideTheConeAndDragsOutsideIt) {
  assets::Scene scene = sceneOf(sheetMesh(0.4, 20));
  scene.materials[0].staticFriction = 0.8;
  scene.materials[0].dynamicFriction = 0.5;
  HandProbe hand(scene);
  hand.at({0.0, 0.0, 0.01});
  hand.to({0.0, 0.0, -0.002}, 1e-4);
  hand.to({0.0015, 0.0, -0.002}, 1e-5);  // inside: 1.5 < 0.8 * 2 mm
  expectNear(hand.out.hands[0].toHand.force, 800.0 * glm::dvec3(-0.0015, 0.0, 0.002), 1e-5);
  const glm::dvec3 stuck = hand.out.worldFromProxy.position;
  for (int i = 0; i < 2000; ++i) hand.at({0.0015 + 2e-5 * (i % 2), 0.0, -0.002});
  EXPECT_EQ(hand.out.worldFromProxy.position, stuck);  // no drift while it sticks
  hand.to({0.05, 0.0, -0.002}, 1e-5);                  // outside: drags at the dynamic coefficient
  EXPECT_NEAR(-hand.out.hands[0].toHand.force.x / hand.out.hands[0].toHand.force.z, 0.5, 1e-4);
}

TEST(Proxy, IsPushedByAMovingPart) {
  for (const double radius : {0.0, 0.002}) {
    SceneBuilder b;
    const PartId part = b.addPart(boxMesh({0.02, 0.02, 0.02}), {}, 1.0);
    HandProbe hand(b.scene);
    hand.parameters.toolRadius = radius;
    hand.at({0.0, 0.0, 0.02});
    Pose pose;
    for (int i = 0; i < 20; ++i) {
      pose.position.z += 0.001;  // 1 m/s
      hand.moved = {{part, pose, {glm::dvec3(0.0, 0.0, 1.0), glm::dvec3(0.0)}}};
      hand.at({0.0, 0.0, 0.02});
    }
    expectNear(hand.out.worldFromProxy.position, {0.0, 0.0, 0.03 + radius}, 1e-8);
    EXPECT_NEAR(hand.out.hands[0].toHand.force.z, 800.0 * (0.01 + radius), 1e-4);
  }
}

TEST(Proxy, StaysOutsideAPartThatJumpsAndTurnsOntoIt) {
  SceneBuilder b;
  const PartId part = b.addPart(boxMesh({0.1, 0.02, 0.02}), {}, 1.0);
  HandProbe hand(b.scene);
  hand.at({0.03, 0.0, 0.012});
  hand.at({0.03, 0.0, 0.012});
  const Pose turned{{0.0, 0.0, 0.0}, fromRotationVector({0.0, -30.0 * kPi / 180.0, 0.0})};
  hand.moved = {{part, turned, {}}};
  hand.at({0.03, 0.0, 0.012});
  const glm::dvec3 inPart = transformPoint(inverse(turned), hand.out.worldFromProxy.position);
  EXPECT_GT(inPart.z, 0.01);
  EXPECT_GT(hand.out.hands[0].toHand.force.z, 0.0);
}

TEST(Proxy, SaysSoWhenSqueezedBetweenTwoParts) {
  SceneBuilder b;
  b.addPart(boxMesh({0.02, 0.02, 0.02}), {{0.0, 0.0, -0.011}, {1.0, 0.0, 0.0, 0.0}});
  const PartId press = b.addPart(boxMesh({0.02, 0.02, 0.02}), {{0.0, 0.0, 0.03}, {1.0, 0.0, 0.0, 0.0}}, 1.0);
  HandProbe hand(b.scene);
  hand.at({0.0, 0.0, 0.005});
  std::uint32_t flags = 0;
  Pose pose{{0.0, 0.0, 0.03}, {1.0, 0.0, 0.0, 0.0}};
  for (int i = 0; i < 25; ++i) {
    pose.position.z -= 0.001;
    hand.moved = {{press, pose, {}}};
    flags |= hand.at({0.0, 0.0, 0.005}).flags;
    EXPECT_LT(glm::length(hand.out.hands[0].toHand.force), 800.0 * 0.03);
  }
  EXPECT_TRUE(flags & haptics::kFlagSqueezed);
}

}  // namespace
}  // namespace tandem::test
