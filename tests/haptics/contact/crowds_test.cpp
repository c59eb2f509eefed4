// A part among more neighbours than a tick has room for.

#include "tests/haptics/contact/part_contact_case.h"

namespace tandem::test {
namespace {

constexpr int kAcross = 14;
constexpr double kTiny = 0.0004, kLength = 0.02;  // m, of a tiny cube and of the held bar

/// A bed of tiny cubes whose tops lie in z = 0, `pitch` m apart, and a bar across it, led 2 mm down into it
/// at y.
PartCase barOnABed(double pitch, double y, double thickness) {
  std::vector<CasePart> parts;
  const glm::dquat straight(1.0, 0.0, 0.0, 0.0);
  const double half = 0.5 * pitch * (kAcross - 1);
  for (int i = 0; i < kAcross * kAcross; ++i) {
    const glm::dvec3 at(pitch * (i % kAcross) - half, pitch * (i / kAcross) - half, -0.5 * kTiny);
    parts.push_back({.name = "t" + std::to_string(i),
                     .mesh = meshOf(boxSoup(glm::dvec3(kTiny))),
                     .worldFromPart = {at, straight}});
  }
  const Pose start{{0.0, y, 0.0015}, straight};
  parts.push_back({.name = "bar",
                   .mesh = meshOf(boxSoup({kLength, thickness, 0.002})),
                   .worldFromPart = start,
                   .movable = true,
                   .mass = 0.05});
  const DevicePath path = [=](double time) {
    return Pose{start.position - glm::dvec3(0.0, 0.0, std::min(0.02 * time, 0.0025)), straight};
  };
  return {"bar_on_a_bed", sceneOfParts(parts), kAcross * kAcross, path, 0.2, {}};
}

/// Rows at both sides of the bed: whichever the tree lists first, one of them comes last.
TEST(Crowds, APartHasThoseNeighboursThatAreNearItsBox) {
  for (const double y : {-0.0091, 0.0091}) {
    HeldPartRig rig(barOnABed(0.0014, y, 0.001));
    rig.run(0);
    EXPECT_NEAR(rig.last().part.position.z, 0.001, kFastDepth) << y;
    EXPECT_GT(rig.mostForce(), 1.0) << y;
    EXPECT_EQ(rig.last().flags & haptics::kFlagOverflow, 0u) << y;
  }
}

TEST(Crowds, MoreThanThereIsRoomForHoldAPartAndAreFlagged) {
  HeldPartRig rig(barOnABed(0.0014, 0.0, 0.02));
  rig.run(0);
  EXPECT_NEAR(rig.last().part.position.z, 0.001, kFastDepth);
  EXPECT_NE(rig.last().flags & haptics::kFlagOverflow, 0u);
}

}  // namespace
}  // namespace tandem::test
