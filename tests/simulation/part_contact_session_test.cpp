// A held part collides in a session as it does alone: the hand that pushes it feels the stop, and all sites
// see it there.

#include <gtest/gtest.h>

#include <glm/geometric.hpp>

#include "client/simulation/simulation.h"
#include "tests/support/part_meshes.h"
#include "tests/support/shapes.h"

namespace tandem::client {
namespace {

constexpr double kPegLength = 0.04, kPegGap = 0.01;  // m

void boundScene(assets::Scene& scene) {
  for (const assets::Part& part : scene.parts) {
    const assets::Bounds box = scene.meshes[part.mesh].bounds;
    for (const glm::dvec3& corner : {box.min, box.max}) {
      const glm::dvec3 at = transformPoint(part.worldFromPart, corner);
      scene.bounds.include(at);
    }
  }
}

/// A plate whose top is y = 0, and a peg that stands over it.
struct PegOverPlate {
  test::SceneBuilder builder;
  PartId peg = kNoPart;

  PegOverPlate() {
    builder.addPart(test::boxMesh({0.08, 0.01, 0.08}), {{0.0, -0.005, 0.0}, {1.0, 0.0, 0.0, 0.0}});
    const glm::dquat upright = glm::angleAxis(-0.5 * kPi, glm::dvec3(1.0, 0.0, 0.0));
    peg = builder.addPart(test::meshOf(test::pegSoup({0.01, kPegLength, 0.001, {16, 1}})),
                          {{0.0, kPegGap, 0.0}, upright}, 0.1);
    boundScene(builder.scene);
  }
  const std::string& name() const { return builder.scene.parts[peg].name; }
};

/// One site takes the peg, pushes it 30 mm down and lets go of it there; another one, the first of the list,
/// watches.
Scenario pushDown(const std::string& part) {
  Scenario scenario;
  scenario.path = "push down";
  scenario.duration = 6.0;
  scenario.network.oneWay = 25 * sync::kMillisecond;
  scenario.network.jitter = 0.2;
  scenario.network.loss = 0.02;
  scenario.sites.resize(2);
  scenario.sites[0].name = "watches";
  scenario.sites[0].script = "[]";
  scenario.sites[1].name = "pushes";
  scenario.sites[1].hasStart = true;
  scenario.sites[1].start = {0.0, kPegGap + kPegLength + 0.02, 0.0};
  scenario.sites[1].script = R"([{"t":0.3,"do":"grasp","part":")" + part + R"(","over_s":0.4},
    {"t":1.2,"do":"move_relative","by":[0.0,-0.03,0.0],"over_s":0.8}, {"t":2.8,"do":"release"}])";
  return scenario;
}

SimulationResult runPeg(const PegOverPlate& made, const haptics::ContactScene& contact,
                        std::uint64_t seed = 1) {
  SimulationOptions options;
  options.seed = seed;
  options.leaderLoad = false;
  Result<SimulationResult> result = simulate(pushDown(made.name()), contact, options);
  EXPECT_TRUE(result.ok()) << (result.ok() ? "" : result.error().message);
  return std::move(*result);
}

TEST(PartContactInASession, APegThatIsPushedOntoAPlateRestsOnItAtEverySite) {
  const PegOverPlate made;
  haptics::ContactScene contact(made.builder.scene);
  ASSERT_TRUE(contact.modelParts());
  const SimulationResult result = runPeg(made, contact);
  // The pose at the watching site. The invariants check that all sites agree.
  ASSERT_EQ(result.finalPoses.count(made.name()), 1u);
  EXPECT_NEAR(result.finalPoses.at(made.name()).position.y, 0.0, 20e-6);
  EXPECT_TRUE(result.violations.empty());
  EXPECT_TRUE(result.stable);
  EXPECT_GT(result.sites.at("pushes").rmsForce, 0.3) << "the stop is felt";
  EXPECT_EQ(runPeg(made, contact).hash, result.hash) << "the same seed gives the same bits";
  EXPECT_NE(runPeg(made, contact, 8).hash, result.hash);
}

TEST(PartContactInASession, WithoutModelsItPassesThrough) {
  const PegOverPlate made;
  const SimulationResult result = runPeg(made, haptics::ContactScene(made.builder.scene));
  ASSERT_EQ(result.finalPoses.count(made.name()), 1u);
  EXPECT_LT(result.finalPoses.at(made.name()).position.y, -0.01);
  EXPECT_LT(result.sites.at("pushes").rmsForce, 0.3);
}

/// A cube 5 mm before another, which stands on rails along x, or on nothing.
assets::Scene cubeBeforeSlider(bool rails) {
  test::SceneBuilder b;
  const std::uint32_t mesh = b.addMesh(test::boxMesh({0.02, 0.02, 0.02}));
  b.addPart(mesh, {{0.0, 0.0, 0.0}, {1.0, 0.0, 0.0, 0.0}}, 0.1);
  const PartId slider = b.addPart(mesh, {{0.025, 0.0, 0.0}, {1.0, 0.0, 0.0, 0.0}}, 0.2);
  if (rails) {
    assets::Joint joint;
    joint.name = "rails";
    joint.partB = slider;
    joint.aFromJoint = b.scene.parts[slider].worldFromPart;
    joint.limits = {{false, 6, 0.0, 0.0, 0.0, 0.0}, {true, 7, 0.0, 0.0, 0.0, 0.0}};
    b.scene.joints.push_back(joint);
  }
  boundScene(b.scene);
  return b.scene;
}

TEST(PartContactInASession, APartThatGivesWayIsAskedForAndGoesAlongAtEverySite) {
  for (const bool rails : {true, false}) {
    const assets::Scene scene = cubeBeforeSlider(rails);
    haptics::ContactScene contact(scene);
    ASSERT_TRUE(contact.modelParts());
    Scenario scenario = pushDown(scene.parts[0].name);
    scenario.sites[1].start = {-0.03, 0.0, 0.0};
    scenario.sites[1].script =
        R"([{"t":0.3,"do":"grasp","part":")" + scene.parts[0].name + R"(","over_s":0.4},
      {"t":1.2,"do":"move_relative","by":[0.02,0.0,0.0],"over_s":1.2}, {"t":3.2,"do":"release"}])";
    SimulationOptions options;
    options.leaderLoad = false;
    const Result<SimulationResult> result = simulate(scenario, contact, options);
    ASSERT_TRUE(result.ok()) << result.error().message;
    EXPECT_TRUE(result->violations.empty());
    const auto slider = result->finalPoses.find(scene.parts[1].name);
    const double displacement = slider == result->finalPoses.end() ? 0.0 : slider->second.position.x - 0.025;
    // The slider moves as far as the hand after the first 5 mm, less the compliance of the modelled arm.
    if (rails)
      EXPECT_NEAR(displacement, 0.015, 2e-3);
    else
      EXPECT_LT(std::abs(displacement), 1e-6);
  }
}

}  // namespace
}  // namespace tandem::client
