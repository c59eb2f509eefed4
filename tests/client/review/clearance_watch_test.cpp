// The thread that measures the held part's clearance: answers arrive, follow the part, and are discarded with
// it.

#include "client/review/clearance_watch.h"

#include <gtest/gtest.h>

#include <chrono>
#include <functional>
#include <thread>

#include "haptics/scene/contact_scene.h"
#include "tests/support/bench_meshes.h"
#include "tests/support/shapes.h"

namespace tandem::test {
namespace {

using client::Clash;
using client::ClearanceWatch;

/// Two cubes of 10 mm, 1 mm apart.
assets::Scene twoCubes() {
  assets::Scene scene = tests::sceneOf(boxMesh(glm::dvec3(0.01)));
  scene.parts.push_back(scene.parts[0]);
  scene.parts[1].worldFromPart.position.x = 0.011;
  return scene;
}

/// Updates the watch as a window would until the answer is as wanted; false after ten seconds.
bool comes(ClearanceWatch& watch, PartId part, const std::vector<Pose>& poses,
           const std::function<bool(const Clash&)>& wanted) {
  for (int i = 0; i < 2000; ++i) {
    const std::optional<Clash> answer = watch.update(part, poses);
    if (answer && wanted(*answer)) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return false;
}

TEST(ClearanceWatch, FollowsTheHeldPartAndForgetsItWhenItIsPutDown) {
  const assets::Scene scene = twoCubes();
  const haptics::ContactScene contact(scene, 1);
  ClearanceWatch watch(contact);
  std::vector<Pose> poses{scene.parts[0].worldFromPart, scene.parts[1].worldFromPart};
  EXPECT_FALSE(watch.update(0, poses).has_value()) << "nobody has measured yet";
  EXPECT_TRUE(
      comes(watch, 0, poses, [](const Clash& c) { return c.b == 1 && std::abs(c.distance - 1e-3) < 1e-12; }));
  poses[0].position.x = -0.002;
  EXPECT_TRUE(comes(watch, 0, poses, [](const Clash& c) { return std::abs(c.distance - 3e-3) < 1e-12; }));
  poses[0].position.x = 0.0015;
  EXPECT_TRUE(comes(watch, 0, poses, [](const Clash& c) { return std::abs(c.depth - 5e-4) < 1e-12; }));
  EXPECT_FALSE(watch.update(kNoPart, poses).has_value());
  EXPECT_FALSE(watch.update(1, poses).has_value()) << "the answer was another part's";
  EXPECT_TRUE(comes(watch, 1, poses, [](const Clash& c) { return c.a == 1 && c.b == 0; }));
}

TEST(ClearanceWatch, EndsWhileItMeasures) {
  const assets::Scene scene = twoCubes();
  const haptics::ContactScene contact(scene, 1);
  const std::vector<Pose> poses{scene.parts[0].worldFromPart, scene.parts[1].worldFromPart};
  for (int i = 0; i < 20; ++i) {
    ClearanceWatch watch(contact);
    watch.update(0, poses);
  }
}

TEST(ClearanceWatch, BearsThatAPartIsPutDownBeforeItIsMeasured) {
  const assets::Scene scene = twoCubes();
  const haptics::ContactScene contact(scene, 1);
  const std::vector<Pose> poses{scene.parts[0].worldFromPart, scene.parts[1].worldFromPart};
  for (int i = 0; i < 50; ++i) {
    ClearanceWatch watch(contact);
    watch.update(0, poses);
    EXPECT_FALSE(watch.update(kNoPart, poses).has_value());
    std::this_thread::yield();
    EXPECT_FALSE(watch.update(kNoPart, poses).has_value());
  }
}

}  // namespace
}  // namespace tandem::test
