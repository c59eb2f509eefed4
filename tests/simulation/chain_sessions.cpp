#include "tests/simulation/chain_sessions.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace tandem::test {
namespace {

using nlohmann::json;

constexpr double kSize = 0.05, kGap = 0.005, kFirst = -0.15, kToWall = 0.015;  // m
constexpr double kGripHeight = 0.06;                                           // m, over the centres

double centreOf(std::size_t box) { return kFirst + (kSize + kGap) * static_cast<double>(box); }

json partOf(const std::string& name, double x, std::size_t shape, double mass) {
  json body = {{"collider", {{"geometry", {{"shape", shape}}}, {"physicsMaterial", 0}}}};
  const double inertia = mass * kSize * kSize / 6.0;
  if (mass > 0.0) body["motion"] = {{"mass", mass}, {"inertiaDiagonal", {inertia, inertia, inertia}}};
  return {
      {"name", name}, {"translation", {x, 0.0, 0.0}}, {"extensions", {{"KHR_physics_rigid_bodies", body}}}};
}

json boxOf(double x, double y, double z) { return {{"type", "box"}, {"box", {{"size", {x, y, z}}}}}; }

assets::Scene sceneOf(const Chain& chain) {
  json nodes = json::array(), order = json::array();
  const json shapes = {boxOf(kSize, kSize, kSize), boxOf(0.04, 0.3, 0.3)};
  for (std::size_t i = 0; i < chain.masses.size(); ++i)
    nodes.push_back(partOf("p" + std::to_string(i), centreOf(i), 0, chain.masses[i]));
  if (chain.wall)
    nodes.push_back(partOf("wall", centreOf(chain.masses.size() - 1) + 0.5 * kSize + kToWall + 0.02, 1, 0.0));
  for (std::size_t i = 0; i < nodes.size(); ++i) order.push_back(i);
  const json material = {{"staticFriction", 0.0}, {"dynamicFriction", 0.0}, {"restitution", 0.0}};
  const json file = {{"asset", {{"version", "2.0"}}},
                     {"scene", 0},
                     {"scenes", json::array({{{"nodes", order}}})},
                     {"nodes", nodes},
                     {"extensionsUsed", {"KHR_physics_rigid_bodies", "KHR_implicit_shapes"}},
                     {"extensions",
                      {{"KHR_implicit_shapes", {{"shapes", shapes}}},
                       {"KHR_physics_rigid_bodies", {{"physicsMaterials", json::array({material})}}}}}};
  const std::string text = file.dump();
  Result<assets::Scene> scene = assets::loadGltfFromMemory("chain.gltf", {text.begin(), text.end()}, {});
  EXPECT_TRUE(scene.ok()) << (scene.ok() ? "" : scene.error().message);
  return std::move(*scene);
}

client::Scenario scenarioOf(const Chain& chain) {
  client::Scenario scenario;
  scenario.path = "chain";
  scenario.duration = 8.5;
  scenario.network.oneWay = static_cast<sync::Micros>(1e3 * chain.delay);
  scenario.network.jitter = 0.2;
  scenario.network.loss = 0.02;
  for (std::size_t i = 0; i < chain.masses.size(); ++i) {
    client::ScenarioSite& site = scenario.sites.emplace_back();
    site.name = "s" + std::to_string(i);
    site.arm = chain.arm;
    site.device.forceMax = chain.deviceForce;
    site.stiffness = 1000.0;
    site.hasStart = true;
    site.start = {centreOf(i), 0.0, kGripHeight};
    json script =
        json::array({{{"t", 0.4}, {"do", "grasp"}, {"part", "p" + std::to_string(i)}, {"over_s", 0.3}}});
    if (i == 0) {
      script.push_back(
          {{"t", 2.0}, {"do", "move_relative"}, {"by", {chain.push, 0.0, 0.0}}, {"over_s", 2.0}});
      script.push_back(
          {{"t", 6.0}, {"do", "move_relative"}, {"by", {-chain.push, 0.0, 0.0}}, {"over_s", 1.0}});
    }
    site.script = script.dump();
  }
  return scenario;
}

}  // namespace

Chain unequalChain(int owners) {
  Chain chain;
  for (int i = 0; i < owners; ++i) chain.masses.push_back(i % 2 == 0 ? 0.05 : 5.0);
  return chain;
}

std::string describe(const Chain& chain) {
  return std::to_string(chain.masses.size()) + " owners, " + std::to_string(chain.delay) + " ms, " +
         std::to_string(chain.deviceForce) + " N" + (chain.wall ? ", wall" : ", free");
}

client::SimulationResult run(const Chain& chain, const client::SimulationOptions& options) {
  const assets::Scene scene = sceneOf(chain);
  haptics::ContactScene contact(scene);
  EXPECT_TRUE(contact.modelParts());
  Result<client::SimulationResult> result = client::simulate(scenarioOf(chain), contact, options);
  EXPECT_TRUE(result.ok()) << (result.ok() ? "" : result.error().message);
  return std::move(*result);
}

}  // namespace tandem::test
