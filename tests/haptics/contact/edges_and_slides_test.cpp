// Contacts of edges: round a sharp rim, across a face made of triangles, over a blade.

#include <numbers>

#include "tests/haptics/contact/part_contact_case.h"

namespace tandem::test {
namespace {

constexpr double kDegree = 0.017453292519943295;

TEST(SharpEdge, PegLedRoundARimTurnsTheForceSmoothly) {
  HeldPartRig rig(pegAlongRimCase());
  rig.run(10);
  report(rig);
  expectSound(rig);
  EXPECT_LE(rig.deepest(), kSteadyDepth);
  // A whole turn in 2 s is 0.18 degrees a tick; of two polyhedra the normal turns by a facet at once.
  const std::vector<double> changes = rig.directionSteps(0.1, 0.3);
  const double facet = 360.0 / kRimSegments * kDegree;
  ASSERT_GT(changes.size(), 1500u);
  EXPECT_LT(quantile(changes, 0.99), facet);
  EXPECT_LT(quantile(changes, 1.0), 2.0 * facet);
  EXPECT_LE(quantile(rig.forceSteps(0.3), 0.99), 0.05);
  // No snag: nowhere along the rim much more force than elsewhere.
  std::vector<double> forces;
  for (const RigTick& t : rig.ticks()) {
    if (t.time > 0.3) forces.push_back(glm::length(t.toHand.force));
  }
  EXPECT_LT(quantile(forces, 1.0), 1.3 * quantile(forces, 0.5));
}

TEST(CoplanarSlide, HasNoBuzzAndNoSnagAtSeams) {
  HeldPartRig rig(coplanarSlideCase(0.1));
  rig.run(5);
  report(rig);
  expectSound(rig);
  EXPECT_LE(rig.deepest(), kSteadyDepth);
  std::vector<double> sideways, torques, torqueSteps;
  for (std::size_t i = 1; i < rig.ticks().size(); ++i) {
    const RigTick &t = rig.ticks()[i], &before = rig.ticks()[i - 1];
    if (t.time < 0.3) continue;  // pressing, and setting off
    EXPECT_NEAR(t.toHand.force.z, 1.0, 0.05) << t.time;
    EXPECT_NEAR(t.part.position.z, 0.005, kSteadyDepth) << t.time;
    sideways.push_back(glm::length(glm::dvec2(t.toHand.force)));
    torques.push_back(glm::length(t.toHand.torque));
    torqueSteps.push_back(glm::length(t.toHand.torque - before.toHand.torque));
  }
  EXPECT_LT(quantile(sideways, 1.0), 0.02);      // N; a seam would hold it back
  EXPECT_LT(quantile(torques, 1.0), 0.2e-3);     // N·m: 1 N off by 0.2 mm
  EXPECT_LT(quantile(torqueSteps, 1.0), 20e-6);  // N·m a tick
}

/// A cube on its edge, askew over a blade of 30 degrees, let down onto it: where that edge crosses the blade
/// between two of its samples, both of those are beside the blade.
TEST(SharpEdge, CrossesABladeWithoutSinkingIn) {
  const glm::dquat lying = fromRotationVector({0.5 * std::numbers::pi, 0.0, 0.0}),
                   onEdge = fromRotationVector({0.25 * std::numbers::pi, 0.0, 0.0});
  for (int i = 0; i < 12; ++i) {
    const double off = 0.19e-3 + 0.01e-3 * (i / 2), high = i % 2 == 0 ? 30e-6 : 45e-6, yaw = 0.6;
    const Pose start{{off, 0.0, 0.005 * std::sqrt(2.0) + high}, fromRotationVector({0.0, 0.0, yaw}) * onEdge};
    assets::Scene scene =
        sceneOfParts({{.name = "blade",
                       .mesh = meshOf(prismSoup({{-0.003, -0.011}, {0.003, -0.011}, {0.0, 0.0}}, 0.04)),
                       .worldFromPart = {{0.0, 0.02, 0.0}, lying}},
                      {.name = "cube",
                       .mesh = meshOf(boxSoup({0.01, 0.01, 0.01})),
                       .worldFromPart = start,
                       .movable = true}});
    const DevicePath path = [start](double time) {
      Pose pose = start;
      pose.position.z -= 1e-3 * std::min(time / 0.3, 1.0);
      return pose;
    };
    HeldPartRig rig({"cube over a blade", std::move(scene), 1, path, 0.35, {}});
    rig.run(5);
    EXPECT_GT(rig.mostForce(0.3), 0.3) << i;
    EXPECT_LT(rig.deepest(), kSteadyDepth) << i;
  }
}

}  // namespace
}  // namespace tandem::test
