// A peg that is pressed askew into its bore with friction: when it slides, and that it comes out again.

#include "tests/haptics/contact/part_contact_case.h"

namespace tandem::test {
namespace {

/// The first tick at which the part is `distance` m from where it was at `since` s; null if there is none.
const RigTick* firstMoved(const HeldPartRig& rig, double since, double distance) {
  const RigTick* start = nullptr;
  for (const RigTick& t : rig.ticks()) {
    if (start == nullptr && t.time >= since) start = &t;
    if (start != nullptr && std::abs(t.part.position.z - start->part.position.z) > distance) return &t;
  }
  return nullptr;
}

void expectThreshold(const JamCase& jam) {
  HeldPartRig rig(jamCase(jam));
  rig.run(20);
  report(rig);
  expectSound(rig);
  EXPECT_LE(rig.deepest(), kSteadyDepth) << rig.given().name;
  const RigTick* sliding = firstMoved(rig, jam.start() + 0.3, 50e-6);
  ASSERT_NE(sliding, nullptr) << rig.given().name;
  const double push = sliding->toHand.force.z, moment = std::abs(sliding->toHand.torque.x);
  const double predicted = 2.0 * jam.friction * moment / (jam.engaged - 0.001);
  if (atFullSize())
    std::printf("  slides at %.3f N, predicted %.3f N (%.3f)\n", push, predicted, push / predicted);
  EXPECT_NEAR(push / predicted, 1.0, 0.1) << rig.given().name;
}

TEST(FrictionJam, SlidesWhereWhitneysDiagramSays) {
  expectThreshold({.engaged = 0.010, .moment = 0.1, .friction = 0.1, .pushed = 1.0});
}

TEST(FrictionJam, SlidesWhereWhitneysDiagramSaysEverywhere) {
  if (!atFullSize()) GTEST_SKIP() << "set TANDEM_FULL_SIZE";
  for (const double engaged : {0.007, 0.01, 0.02, 0.03}) {
    for (const double friction : {0.1, 0.15, 0.2}) {
      // What leaning by its play takes, and as much as is to hold it: 2.4 N at mu 0.1.
      const double span = engaged - 0.001, play = 0.1e-3 / span;
      expectThreshold({.engaged = engaged, .moment = 4.0 * play + 12.0 * span, .friction = friction});
    }
  }
}

TEST(FrictionJam, PegTakenInsideItsBoreStaysOutOfTheWall) {
  // With air all round there is no overlap to remember, however coarse the field is near the rims.
  HeldPartRig rig(jamCase({.pushed = 0.6, .takenInside = true}));
  rig.run(20);
  expectSound(rig);
  EXPECT_LE(rig.deepest(), kSteadyDepth);
}

TEST(FrictionJam, WithoutFrictionNothingHoldsIt) {
  // The control of the test above: the same moment, and the peg follows the push.
  HeldPartRig rig(jamCase({.friction = 0.0, .pushed = 0.6}));
  rig.run(20);
  expectSound(rig);
  EXPECT_NEAR(rig.last().part.position.z, rig.last().device.position.z, 0.15e-3);
}

TEST(FrictionJam, WedgedPegComesOutWhenPulled) {
  // 3 mm between contacts of a 20 mm peg at mu 0.2: it wedges. Pushed by 6 N, straightened and pulled out.
  const JamCase jam{.engaged = 0.004, .moment = 0.1, .friction = 0.2, .pushed = 1.5, .pullsOut = true};
  HeldPartRig rig(jamCase(jam));
  rig.run(20);
  report(rig);
  expectSound(rig);
  EXPECT_LE(rig.deepest(), kSteadyDepth);
  for (const RigTick& t : rig.ticks()) {
    if (std::abs(t.time - jam.start() - 1.5) < 5e-4) {
      EXPECT_GT(t.part.position.z - t.device.position.z, 1e-3);  // it was stuck
    }
  }
  EXPECT_NEAR(rig.last().part.position.z, rig.last().device.position.z, 0.5e-3);
}

}  // namespace
}  // namespace tandem::test
