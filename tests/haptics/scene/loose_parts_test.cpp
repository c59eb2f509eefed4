// Thousands of parts that move at once are kept out of the scene tree. Nobody may notice but the clock.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include <glm/geometric.hpp>

#include "haptics/scene/contact_world.h"
#include "haptics/tick.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/bench_meshes.h"

namespace tandem::test {
namespace {

using haptics::ContactScene;
using haptics::ContactWorld;

/// Parts whose centre lies in the box: those a query must find, whatever the boxes.
std::vector<PartId> centresIn(const ContactWorld& world, const assets::Bounds& box) {
  std::vector<PartId> parts;
  for (PartId i = 0; world.has(i); ++i) {
    const glm::dvec3& p = world.pose(i).position;
    const bool in = glm::all(glm::lessThanEqual(box.min, p)) && glm::all(glm::lessThanEqual(p, box.max));
    if (in) parts.push_back(i);
  }
  return parts;
}

/// Every part is found at most once, and all of those are.
void expectFinds(const ContactWorld& world, const assets::Bounds& box) {
  std::vector<PartId> found;
  world.forEachNear(box, [&](PartId part) { found.push_back(part); });
  std::sort(found.begin(), found.end());
  EXPECT_TRUE(std::adjacent_find(found.begin(), found.end()) == found.end());
  const std::vector<PartId> expected = centresIn(world, box);
  EXPECT_TRUE(std::includes(found.begin(), found.end(), expected.begin(), expected.end()));
  EXPECT_LT(found.size(), 350u);  // and others whose way of this tick leads through
}

TEST(LooseParts, QueriesFindThemWhereTheyAreInsideAndOutsideTheRegion) {
  const assets::Scene scene = tests::smallParts(400);
  const ContactScene contact(scene);
  ContactWorld world(contact);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> u(-0.05, 0.05);
  const assets::Bounds region{glm::dvec3(-0.01), glm::dvec3(0.01)};
  for (int tick = 0; tick < 40; ++tick) {
    const AllocationScope scope;
    world.beginMotions(region);
    for (PartId i = 0; i < 400; ++i) {
      if ((i + static_cast<PartId>(tick)) % 3 == 0) continue;  // each stands still in every third tick
      const Pose pose{{u(random), u(random), u(random)}, {1.0, 0.0, 0.0, 0.0}};
      if (world.noteMotion(i, pose)) world.setNearPose(i, pose, {});
    }
    world.endMotions();
    EXPECT_EQ(scope.count(), 0u);
    expectFinds(world, region);
    const glm::dvec3 p(u(random), u(random), u(random));
    expectFinds(world, {p - 0.01, p + 0.01});
    world.setPose(5, {p, {1.0, 0.0, 0.0, 0.0}}, {});  // by another way, in between
    expectFinds(world, {p - 0.01, p + 0.01});
  }
}

TEST(LooseParts, AreFoundWhenTheRegionIsWidenedBeforeTheyHaveMoved) {
  const assets::Scene scene = tests::smallParts(4);
  const ContactScene contact(scene);
  ContactWorld world(contact);
  const Pose far{{0.5, 0.0, 0.0}, {1.0, 0.0, 0.0, 0.0}};
  world.beginMotions({glm::dvec3(-0.01), glm::dvec3(0.01)});
  ASSERT_TRUE(world.noteMotion(2, far));
  world.endMotions();
  expectFinds(world, {glm::dvec3(-0.1), glm::dvec3(0.1)});  // larger than the region
  world.setNearPose(2, far, {});
  expectFinds(world, {glm::dvec3(0.45, -0.05, -0.05), glm::dvec3(0.55, 0.05, 0.05)});
  expectFinds(world, {glm::dvec3(-1.0), glm::dvec3(1.0)});
}

TEST(LooseParts, GoBackIntoTheTreeWhenTheyStandStill) {
  const assets::Scene scene = tests::smallParts(400);
  const ContactScene contact(scene);
  ContactWorld world(contact);
  world.beginMotions({glm::dvec3(-0.01), glm::dvec3(0.01)});
  for (PartId i = 0; i < 400; ++i) {
    const Pose pose{scene.parts[i].worldFromPart.position + glm::dvec3(0.001), {1.0, 0.0, 0.0, 0.0}};
    if (world.noteMotion(i, pose)) world.setNearPose(i, pose, {});
  }
  EXPECT_TRUE(world.anyLoose());
  for (int tick = 0; tick < 20 && world.anyLoose(); ++tick) {
    world.beginMotions({glm::dvec3(-0.01), glm::dvec3(0.01)});
    world.endMotions();
    expectFinds(world, {glm::dvec3(-0.02), glm::dvec3(0.02)});
  }
  EXPECT_FALSE(world.anyLoose());
}

/// A part comes up under the tool, alone or among many others that swing far away or pass through the tool's
/// plane.
std::vector<glm::dvec3> forcesUnder(bool crowd) {
  const assets::Scene scene = tests::smallParts(400);
  const ContactScene contact(scene);
  haptics::TickState state(contact);
  haptics::TickParameters parameters;
  parameters.toolRadius = 0.0005;
  std::vector<glm::dvec3> forces;
  std::vector<haptics::PartMotion> motions;
  constexpr PartId kPusher = 210;
  for (int tick = 0; tick < 150; ++tick) {
    motions.clear();
    for (PartId i = 0; i < 400; ++i) {
      const glm::dvec3 rest = scene.parts[i].worldFromPart.position;
      haptics::PartMotion m;
      m.part = i;
      m.worldFromPart.position = rest;
      if (i == kPusher) {
        m.worldFromPart.position.z += 2e-5 * std::min(tick, 100);
        m.twist.linear.z = tick < 100 ? 0.02 : 0.0;
      } else if (crowd && glm::distance(rest, scene.parts[kPusher].worldFromPart.position) > 0.012) {
        m.worldFromPart.position.z += 1e-3 * std::sin(0.1 * tick + i);
      } else {
        continue;
      }
      motions.push_back(m);
    }
    haptics::TickInput input;
    input.hands[0].device.valid = true;
    input.hands[0].device.worldFromDevice.position =
        scene.parts[kPusher].worldFromPart.position + glm::dvec3(0.0002, 0.0001, 0.0028);
    input.moved = motions;
    const haptics::TickOutput out = haptics::tick(input, contact, parameters, state);
    EXPECT_EQ(out.flags & (haptics::kFlagOverflow | haptics::kFlagSqueezed), 0u);
    forces.push_back(out.hands[0].toHand.force);
  }
  return forces;
}

TEST(LooseParts, TheToolFeelsAPartAmongHundredsAsItFeelsItAlone) {
  const std::vector<glm::dvec3> alone = forcesUnder(false), among = forcesUnder(true);
  EXPECT_GT(glm::length(alone.back()), 0.5);
  for (std::size_t i = 0; i < alone.size(); ++i) EXPECT_EQ(alone[i], among[i]) << i;
}

TEST(LooseParts, APartThatFliesThroughTheRegionInOneTickIsNotMissed) {
  const assets::Scene scene = tests::smallParts(4);
  const ContactScene contact(scene);
  ContactWorld world(contact);
  const assets::Bounds region{glm::dvec3(-0.001), glm::dvec3(0.001)};
  const auto at = [](double x, double y) { return Pose{{x, y, 0.0}, {1.0, 0.0, 0.0, 0.0}}; };
  world.setPose(0, at(-0.06, 0.001), {});
  world.beginMotions(region);
  EXPECT_FALSE(world.noteMotion(0, at(-0.06, 0.0)));
  EXPECT_EQ(world.pose(0).position.y, 0.0);
  world.endMotions();
  world.beginMotions(region);
  EXPECT_TRUE(world.noteMotion(0, at(0.06, 0.0)));  // far on either side
  EXPECT_EQ(world.pose(0).position.x, -0.06);       // until setNearPose
}

}  // namespace
}  // namespace tandem::test
