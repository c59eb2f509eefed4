// What rests edge on edge, where a field has no direction: the planes of the last exact answers hold it, and
// few samples are queried anew.

#include "tests/haptics/contact/moving_rig.h"
#include "tests/haptics/contact/part_contact_case.h"
#include "tests/support/part_meshes.h"

namespace tandem::test {
namespace {

struct GearAtRest {
  double queries = 0.0;  // mean of a tick
  double depth = 0.0;    // m, in the end
};

/// A gear that is pressed with 1 N on one of the same shape, which others have raised into it by `raised` m.
GearAtRest restOnGear(double raised) {
  SpurGear gear;
  gear.module = 0.001;
  gear.teeth = 8;
  gear.width = 0.002;
  gear.bore = 0.001;
  gear.flankPoints = 3;
  const assets::Mesh mesh = meshOf(spurGearSoup(gear));
  const glm::dquat straight(1.0, 0.0, 0.0, 0.0);
  const Pose below{glm::dvec3(0.0), straight}, above{{0.0, 0.0, gear.width}, straight};
  MovingRig rig(sceneOfParts({{.name = "below", .mesh = mesh, .worldFromPart = below, .movable = true},
                              {.name = "above", .mesh = mesh, .worldFromPart = above, .movable = true}}));
  rig.takeHold(1, above);
  rig.at({{0.0, 0.0, gear.width - 1.0 / rig.parameters.graspStiffness}, straight});
  rig.tick(30);
  haptics::PartMotion rise;
  rise.part = 0;
  rise.worldFromPart = {{0.0, 0.0, raised}, straight};
  rig.moved = {rise};
  rig.tick(20);
  constexpr int kTicks = 20;
  int queries = 0;
  rig.each = [&] { queries += rig.contact().work().exact; };
  rig.tick(kTicks);
  return {static_cast<double>(queries) / kTicks, gear.width + raised - rig.pose(1).position.z};
}

TEST(AnsweredPlanes, HoldWhatIsTooLittleInsideToBeMovedOut) {
  const GearAtRest rest = restOnGear(0.05e-6);
  EXPECT_LT(rest.queries, 100.0);
  EXPECT_LT(rest.depth, 0.06e-6);
}

/// The planes forgive no more than an exact row does: what is deeper than that is queried in every tick.
TEST(AnsweredPlanes, ThatDemandAWayOutAreQueried) {
  const GearAtRest rest = restOnGear(0.15e-6);
  EXPECT_GT(rest.queries, 300.0);
  EXPECT_LT(rest.depth, 0.16e-6);
}

}  // namespace
}  // namespace tandem::test
