// A plate of 0.5 mm that is thrown onto another.

#include "tests/haptics/contact/part_contact_case.h"

namespace tandem::test {
namespace {

void expectHeld(double speed, double depth) {
  for (std::uint32_t seed = 0; seed < (atFullSize() ? 20u : 2u); ++seed) {
    HeldPartRig rig(plateOnPlateCase(speed, seed));
    rig.run(1);
    report(rig);
    expectSound(rig);
    const std::string& name = rig.given().name;
    EXPECT_LE(rig.deepest(), depth) << name;
    EXPECT_GT(rig.last().part.position.z, 0.0004) << name;  // the other is between -0.25 and 0.25 mm
    for (const RigTick& t : rig.ticks()) {
      ASSERT_GT(t.part.position.z, 0.0) << name << " at " << t.time;
      if (t.contacts > 0) {
        ASSERT_GT(t.firstNormal.z, 0.0) << name << " at " << t.time;
      }
    }
  }
}

TEST(ThinPlates, HoldEachOtherAtTwoHundredMillimetresASecond) { expectHeld(0.2, kFastDepth); }
TEST(ThinPlates, HoldEachOtherAtOneMetreASecond) { expectHeld(1.0, 0.25e-3); }
TEST(ThinPlates, HoldEachOtherAtTwoMetresASecond) { expectHeld(2.0, 0.25e-3); }

}  // namespace
}  // namespace tandem::test
