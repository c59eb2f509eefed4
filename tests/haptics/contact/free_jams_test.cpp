// Several free parts between a hand and a rigid obstacle: hard systems of contacts.

#include "tests/haptics/contact/moving_rig.h"
#include "tests/haptics/contact/part_contact_case.h"
#include "tests/support/part_meshes.h"

namespace tandem::test {
namespace {

const glm::dquat kUnturned(1.0, 0.0, 0.0, 0.0);
const glm::dvec3 kDownwards(0.0, 0.0, -9.81);

/// A slot along x of three walls and a floor, with cubes of 10 mm in it: `wide` m more than the cubes.
assets::Scene slot(int cubes, double wide, double friction, double lastMass) {
  const double half = 0.005 + 0.5 * wide;
  std::vector<CasePart> parts{{.name = "floor",
                               .mesh = meshOf(boxSoup({0.2, 0.1, 0.02})),
                               .worldFromPart = {{0.05, 0.0, -0.01}, kUnturned},
                               .friction = friction},
                              {.name = "left",
                               .mesh = meshOf(boxSoup({0.2, 0.02, 0.03})),
                               .worldFromPart = {{0.05, half + 0.01, 0.015}, kUnturned},
                               .friction = friction},
                              {.name = "right",
                               .mesh = meshOf(boxSoup({0.2, 0.02, 0.03})),
                               .worldFromPart = {{0.05, -half - 0.01, 0.015}, kUnturned},
                               .friction = friction},
                              {.name = "end",
                               .mesh = meshOf(boxSoup({0.02, 2.0 * half, 0.03})),
                               .worldFromPart = {{0.11, 0.0, 0.015}, kUnturned},
                               .friction = friction}};
  for (int i = 0; i < cubes; ++i)
    parts.push_back({.name = "cube" + std::to_string(i),
                     .mesh = meshOf(boxSoup({0.01, 0.01, 0.01})),
                     .worldFromPart = {{0.0947 - 0.0103 * (cubes - 1 - i), 0.0, 0.005}, kUnturned},
                     .movable = true,
                     .friction = friction,
                     .mass = i + 1 == cubes ? lastMass : 0.0});
  return sceneOfParts(parts);
}

/// How deep the corners of any box are in any other, m.
double deepest(const MovingRig& rig) {
  double greatest = 0.0;
  const assets::Scene& scene = rig.scene();
  for (PartId a = 0; a < scene.parts.size(); ++a) {
    for (PartId b = 0; b < scene.parts.size(); ++b) {
      if (a == b || (a < 4 && b < 4)) continue;
      const glm::dvec3 half = scene.meshes[scene.parts[b].mesh].bounds.max;
      for (const glm::dvec3& corner : scene.meshes[scene.parts[a].mesh].positions) {
        const glm::dvec3 inside =
            half - glm::abs(transformPoint(inverse(rig.pose(b)), transformPoint(rig.pose(a), corner)));
        greatest = std::max(greatest, std::min({inside.x, inside.y, inside.z}));
      }
    }
  }
  return greatest;
}

/// The first cube in the hand, the others before it, all 0.3 mm apart, driven to the end of the slot and 30
/// mm beyond: 30 N.
struct Pushed {
  Pushed(int cubes, double wide, double friction, double lastMass = 0.0)
      : rig(slot(cubes, wide, friction, lastMass), kDownwards) {
    const Pose grip = rig.pose(4);
    rig.at(grip);
    rig.tick();
    for (int i = 0; i < cubes; ++i) rig.own(static_cast<PartId>(4 + i));
    rig.grasp(4);
    rig.tick(50);
    const double path = 0.0003 * cubes + 0.03;
    rig.each = [&] { deep = std::max(deep, deepest(rig)); };
    rig.lead(
        [&](double t) {
          return Pose{grip.position + glm::dvec3(2.0 * path * t, 0.0, 0.0), kUnturned};
        },
        0.5);
    rig.tick(250);
    for (int i = 0; i < cubes; ++i) before.push_back(rig.pose(static_cast<PartId>(4 + i)));
    force = rig.out.hands[0].toHand.force;
    rig.tick(250);
  }
  MovingRig rig;
  double deep = 0.0;
  glm::dvec3 force{0.0, 0.0, 0.0};
  std::vector<Pose> before;
};

TEST(FreeJams, CubesPushedHardToTheEndOfASlotStandStill) {
  for (const double friction : {0.0, 0.3}) {
    Pushed slot(4, 2e-4, friction);
    EXPECT_LE(slot.deep, kFastDepth) << friction;
    EXPECT_NEAR(slot.force.x, -30.0, 0.5) << friction;
    EXPECT_NEAR(slot.rig.pose(7).position.x, 0.095, 1e-5) << friction;
    for (std::size_t i = 0; i < slot.before.size(); ++i) {
      const glm::dvec3 drift = slot.rig.pose(static_cast<PartId>(4 + i)).position - slot.before[i].position;
      // Without friction a row of cubes under pressure may buckle sideways, as far as the slot is wide.
      EXPECT_LT(friction > 0.0 ? glm::length(drift) : std::abs(drift.x), 2e-6) << friction;
      EXPECT_LT(glm::length(drift), 2e-4) << friction;
    }
    EXPECT_LT(glm::length(slot.rig.out.hands[0].toHand.force - slot.force), 0.05) << friction;
    EXPECT_EQ(slot.rig.flags & haptics::kFlagFault, 0u);
  }
}

TEST(FreeJams, AThousandTimesLighterPartIsHeldBetweenHeavyOnes) {
  for (const double mass : {0.01, 1e-5, 10.0}) {
    Pushed slot(2, 2e-4, 0.2, mass);
    EXPECT_LE(slot.deep, kFastDepth) << mass;
    EXPECT_NEAR(slot.rig.pose(5).position.x, 0.095, 1e-5) << mass;
    EXPECT_NEAR(slot.force.x, -30.0, 0.5) << mass;
    EXPECT_LT(glm::length(slot.rig.pose(5).position - slot.before[1].position), 2e-6) << mass;
  }
}

}  // namespace
}  // namespace tandem::test
