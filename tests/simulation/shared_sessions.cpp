#include "tests/simulation/shared_sessions.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <nlohmann/json.hpp>

namespace tandem::test {

haptics::ArmParameters relaxedArm() { return {}; }
haptics::ArmParameters firmArm() { return {1.5, 300.0, 12.0, 800.0, 10.0}; }
haptics::ArmParameters lightArm() { return {1.46, 4.88, 4.5, 375.0, 7.9}; }

SharedSession::SharedSession(const std::string& name, Contact contact) {
  const std::string path = std::string(TANDEM_SOURCE_DIR) + "/tests/simulation/scenarios/" + name + ".json";
  Result<client::Scenario> loaded = client::loadScenario(path);
  EXPECT_TRUE(loaded.ok()) << (loaded.ok() ? "" : loaded.error().message);
  scenario = std::move(*loaded);
  Result<assets::Scene> scene = assets::loadGltf(scenario.scene, scenario.load);
  EXPECT_TRUE(scene.ok()) << (scene.ok() ? "" : scene.error().message);
  scene_ = std::move(*scene);
  contact_ = std::make_shared<haptics::ContactScene>(scene_);
  if (contact == Contact::models) {
    EXPECT_TRUE(contact_->modelParts());
  }
  options.leaderLoad = false;
}

void SharedSession::delayGrasp(std::size_t site, double seconds) {
  nlohmann::json script = nlohmann::json::parse(scenario.sites[site].script);
  for (auto& step : script)
    if (step["do"] == "grasp") step["t"] = step["t"].get<double>() + seconds;
  scenario.sites[site].script = script.dump();
}

client::SimulationResult SharedSession::run() const {
  Result<client::SimulationResult> result = client::simulate(scenario, *contact_, options);
  EXPECT_TRUE(result.ok()) << (result.ok() ? "" : result.error().message);
  return std::move(*result);
}

std::uint64_t sessions() {
  const char* text = std::getenv("TANDEM_SEEDS");
  return text != nullptr ? std::strtoull(text, nullptr, 10) : 1000;
}

std::uint64_t seedsUpTo(std::uint64_t most) { return std::clamp<std::uint64_t>(sessions() / 50, 1, most); }

std::string describe(const client::SimulationResult& result) {
  std::string text;
  for (const client::Violation& violation : result.violations)
    text += violation.rule + " at " + std::to_string(violation.at) + " s: " + violation.what + "\n";
  for (const auto& grant : result.grants)
    text += "grant at " + std::to_string(grant.at) + " s: part " + std::to_string(grant.part) + " to " +
            std::to_string(grant.site) + " epoch " + std::to_string(grant.epoch) + "\n";
  return text;
}

}  // namespace tandem::test
