// A cube that is wholly inside a block when it begins to move.

#include "tests/haptics/contact/part_contact_case.h"

namespace tandem::test {
namespace {

TEST(Containment, IsFoundAndPushedOutTheNearestWay) {
  // 10 mm from the middle of the block: the nearest face is that at x = 30 mm, 7.5 mm from the cube's.
  HeldPartRig rig(cubeInBlockCase({0.020, 0.003, -0.001}));
  rig.run(20);
  report(rig);
  expectSound(rig);
  const glm::dvec3 force = rig.last().toHand.force;
  EXPECT_GT(force.x, 0.0);
  EXPECT_LT(glm::length(glm::dvec2(force.y, force.z)), 0.1 * force.x);
  EXPECT_GT(rig.last().part.position.x, 0.0325 - kFastDepth);
  EXPECT_LE(rig.ticks().back().depth >= 0.0 ? rig.ticks().back().depth : 0.0, kFastDepth);
}

TEST(Containment, ForceGrowsAtALimitedRate) {
  haptics::TickParameters parameters = rigParameters();
  parameters.slewLimit = 200.0;
  HeldPartRig rig(cubeInBlockCase({0.020, 0.003, -0.001}), parameters);
  rig.run(0);
  expectSound(rig);
  EXPECT_GT(rig.mostForce(), 1.0);
  EXPECT_LE(quantile(rig.forceSteps(), 1.0), 0.2 * 1.01);
}

}  // namespace
}  // namespace tandem::test
