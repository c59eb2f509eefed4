// A block pushed hard into a gap that is too narrow for it.

#include "tests/haptics/contact/part_contact_case.h"

namespace tandem::test {
namespace {

TEST(JammedBlocks, PushedHardStayStillAndBounded) {
  const double push = 0.03;  // m: 30 N
  HeldPartRig rig(threeBlocksCase(push));
  rig.run(20);
  report(rig);
  expectSound(rig);
  EXPECT_LE(rig.deepest(), kFastDepth);
  EXPECT_GT(rig.last().part.position.z, 0.0145);  // it sits on the two others, whose tops are at 10 mm
  EXPECT_LT(rig.mostForce(), 1.1e3 * push);
  EXPECT_LT(rig.driftOver(0.5), 1e-6);
  EXPECT_LE(quantile(rig.forceSteps(0.6), 1.0), 0.05);
}

}  // namespace
}  // namespace tandem::test
