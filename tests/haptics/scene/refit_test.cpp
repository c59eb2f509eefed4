// A mesh whose points move while it is felt.

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <memory>
#include <random>
#include <thread>
#include <vector>

#include <glm/geometric.hpp>

#include "haptics/geometry/triangle_bvh.h"
#include "haptics/scene/contact_scene.h"
#include "haptics/tick.h"
#include "tests/support/bench_meshes.h"

namespace tandem::test {
namespace {

using haptics::MeshPoint;
using haptics::TriangleBvh;

TEST(TriangleBvhRefit, AnswersAsATreeBuiltAnew) {
  assets::Mesh mesh = tests::sphereMesh(1.0, 20'000, tests::Topology::never);
  TriangleBvh tree(mesh, 2);
  for (glm::dvec3& p : mesh.positions) {
    p = glm::dvec3(1.7 * p.x + 0.3 * std::sin(3.0 * p.y), p.y * (1.0 + 0.5 * p.z), p.z) +
        glm::dvec3(5.0, 0.0, -2.0);
  }
  tree.refit(2);
  const TriangleBvh fresh(mesh, 2);
  EXPECT_EQ(tree.bounds().min, fresh.bounds().min);
  EXPECT_EQ(tree.bounds().max, fresh.bounds().max);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> u(-2.0, 2.0);
  int hits = 0;
  for (int i = 0; i < 300; ++i) {
    const glm::dvec3 p = glm::dvec3(5.0, 0.0, -2.0) + glm::dvec3(u(random), u(random), u(random));
    MeshPoint a, b;
    ASSERT_TRUE(tree.closestPoint(p, 10.0, a));
    ASSERT_TRUE(fresh.closestPoint(p, 10.0, b));
    EXPECT_EQ(a.distance, b.distance);
    const double radius = i % 2 == 0 ? 0.0 : 0.9 * a.distance;
    haptics::MeshBallHit x, y;
    const glm::dvec3 motion(u(random), u(random), u(random));
    const bool hit = tree.sweepBall(p, motion, radius, 1e-10, x);
    EXPECT_EQ(hit, fresh.sweepBall(p, motion, radius, 1e-10, y));
    EXPECT_EQ(x.t, y.t);
    hits += hit ? 1 : 0;
  }
  EXPECT_GT(hits, 30);
}

TEST(RefitMesh, ToolOnASurfaceThatRisesAndFallsFeelsItsNewDepth) {
  assets::Scene scene = tests::plateGrid(1, 0.1, 0.02);
  haptics::ContactScene contact(scene, 1);
  haptics::TickState state(contact);
  haptics::TickParameters parameters;
  parameters.stiffness = 1000.0;
  parameters.damping = 0.0;
  parameters.slewLimit = 1e9;
  haptics::TickInput input;
  input.hands[0].device.valid = true;
  haptics::TickOutput out;
  const auto press = [&](double z) {
    input.hands[0].device.worldFromDevice.position = {0.001, 0.002, z};
    out = haptics::tick(input, contact, parameters, state);
  };
  press(0.001);
  for (int i = 0; i < 3; ++i) press(-0.001);
  ASSERT_NEAR(out.hands[0].toHand.force.z, 1.0, 1e-4);
  for (const double height : {0.0005, 0.001, 0.0002, -0.0004}) {
    const auto moved = [&](glm::dvec3& p) {
      if (p.z > -0.01) p.z = height;
    };
    for (glm::dvec3& p : scene.meshes[0].positions) moved(p);
    contact.refitMesh(0, 1);
    state.meshesChanged(0);
    for (int i = 0; i < 50; ++i) press(-0.001);  // the force may be ramped
    EXPECT_NEAR(out.worldFromProxy.position.z, height, 1e-8);
    EXPECT_NEAR(out.hands[0].toHand.force.z, 1000.0 * (height + 0.001), 1e-4) << height;
  }
}

/// A slab whose upper face is at `height`.
void lift(assets::Mesh& mesh, double height) {
  for (glm::dvec3& p : mesh.positions) {
    if (p.z > -0.01) p.z = height;
  }
}

// One thread deforms and refits the scene that is not felt while another ticks on the other one; they swap.
TEST(RefitMesh, SpareSceneIsRefittedByAnotherThreadWhileTheOtherIsFelt) {
  const assets::Scene scene = tests::plateGrid(1, 0.1, 0.02);
  const haptics::ContactScene first(scene, 1);
  std::shared_ptr<assets::Mesh> meshes[2];
  std::vector<haptics::ContactScene> scenes;
  for (std::shared_ptr<assets::Mesh>& mesh : meshes) {
    mesh = std::make_shared<assets::Mesh>(scene.meshes[0]);
    scenes.push_back(first.withMesh(0, mesh, 1));
  }
  constexpr int kSwaps = 30;
  const auto heightOf = [](int swap) { return 0.0005 * std::sin(0.2 * swap); };
  std::atomic<int> ready{0}, taken{0};
  std::thread deformer([&] {
    for (int swap = 1; swap <= kSwaps; ++swap) {
      while (taken.load(std::memory_order_acquire) != swap - 1) std::this_thread::yield();
      const auto spare = static_cast<std::size_t>(swap % 2);
      lift(*meshes[spare], heightOf(swap));
      scenes[spare].refitMesh(0, 1);
      ready.store(swap, std::memory_order_release);
    }
  });

  haptics::TickState state(scenes[0]);
  haptics::TickParameters parameters;
  parameters.stiffness = 1000.0;
  parameters.damping = 0.0;
  parameters.slewLimit = 1e9;
  haptics::TickInput input;
  input.hands[0].device.valid = true;
  input.hands[0].device.worldFromDevice.position = {0.001, 0.002, 0.001};
  haptics::tick(input, scenes[0], parameters, state);
  input.hands[0].device.worldFromDevice.position.z = -0.001;
  const haptics::ContactScene* felt = &scenes[0];
  int now = 0;
  while (now < kSwaps) {
    const int newest = ready.load(std::memory_order_acquire);
    if (newest != now) {
      now = newest;
      felt = &scenes[static_cast<std::size_t>(now % 2)];
      state.adopt(*felt);
      taken.store(now, std::memory_order_release);  // the other one is the spare from here on
    }
    const haptics::TickOutput out = haptics::tick(input, *felt, parameters, state);
    EXPECT_NEAR(out.hands[0].toHand.force.z, 1000.0 * (heightOf(now) + 0.001), 1e-4) << now;
    std::this_thread::yield();
  }
  deformer.join();
}

}  // namespace
}  // namespace tandem::test
