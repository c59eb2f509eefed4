// A cube pressed by 1 mm onto blocks whose files are dirty feels what it feels on a clean one.

#include "tests/haptics/contact/part_contact_case.h"

namespace tandem::test {
namespace {

void expectSolid(Dirt dirt) {
  HeldPartRig rig(dirtyShellsCase(dirt));
  rig.run(10);
  report(rig);
  expectSound(rig);
  EXPECT_NEAR(rig.last().part.position.z, 0.005, kSteadyDepth) << rig.given().name;
  EXPECT_NEAR(rig.last().toHand.force.z, 1.0, 0.01) << rig.given().name;
  EXPECT_LT(rig.driftOver(0.2), 1e-6) << rig.given().name;
}

TEST(DirtyShells, CleanBlockIsSolid) { expectSolid(Dirt::none); }
TEST(DirtyShells, BlockInsideOutIsSolid) { expectSolid(Dirt::insideOut); }
TEST(DirtyShells, BlockOfTurnedTrianglesIsSolid) { expectSolid(Dirt::flipped); }
TEST(DirtyShells, BlockWithHolesIsSolid) { expectSolid(Dirt::torn); }

}  // namespace
}  // namespace tandem::test
