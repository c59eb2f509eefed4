// Ticks that helpers share give the same results as those of one thread, bit by bit.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "haptics/base/tick_helpers.h"
#include "tests/haptics/contact/part_contact_case.h"

namespace tandem::test {
namespace {

/// A nut that is turned and pushed down on its bolt by one thread of 16 mm.
PartCase turnedNut() {
  Thread thread;
  thread.clearance = 0.2e-3;
  thread.length = 0.010;
  thread.segments = 40;
  thread.perPitch = 1;
  Thread shorter = thread;
  shorter.length = 0.005;
  const Pose engaged{{0.0, 0.0, 0.004}, glm::dquat(1.0, 0.0, 0.0, 0.0)};
  assets::Scene scene = sceneOfParts({{"nut", meshOf(nutThreadSoup(shorter, 0.012)), {}, true},
                                      {"bolt", meshOf(boltThreadSoup(thread)), {}, false}});
  scene.parts[0].worldFromPart = engaged;
  const auto path = [=](double t) {
    Pose pose = engaged;
    pose.orientation = fromRotationVector({0.0, 0.0, -2.0 * std::numbers::pi * std::max(0.0, t - 0.05)});
    pose.position.z -= 2e-3 * std::min(1.0, t / 0.05);
    return pose;
  };
  return {"nut_on_thread", std::move(scene), 0, path, 0.1, {}};
}

/// The ticks of the nut with so many helpers. `shared`: those that were heavy enough for them.
std::vector<RigTick> turnWith(int count, int& shared) {
  haptics::TickHelpers helpers(count);
  HeldPartRig rig(turnedNut(), rigParameters(), cachedModels());
  rig.share(&helpers);
  shared = 0;
  for (double t = 0.001; t < rig.given().duration; t += 0.001) {
    rig.runTo(t, 0);
    shared += rig.sharesTicks() ? 1 : 0;
  }
  return rig.ticks();
}

TEST(SharedGather, GivesTheSameResults) {
  int alone = 0;
  const std::vector<RigTick> expected = turnWith(0, alone);
  EXPECT_EQ(alone, 0);
  ASSERT_GT(expected.size(), 80u);
  EXPECT_GT(glm::length(expected.back().toHand.force), 0.5);
  int shared = 0;
  const std::vector<RigTick> ticks = turnWith(2, shared);
  EXPECT_GT(shared, 40);
  ASSERT_EQ(ticks.size(), expected.size());
  for (std::size_t i = 0; i < ticks.size(); ++i) {
    ASSERT_EQ(ticks[i].part.position, expected[i].part.position) << i;
    ASSERT_EQ(ticks[i].part.orientation, expected[i].part.orientation) << i;
    ASSERT_EQ(ticks[i].toHand.force, expected[i].toHand.force) << i;
    ASSERT_EQ(ticks[i].toHand.torque, expected[i].toHand.torque) << i;
  }
}

}  // namespace
}  // namespace tandem::test
