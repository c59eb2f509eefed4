#include "tests/simulation/shared_sessions.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <map>
#include <tuple>

#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>

#include "tests/support/full_size.h"
#include "tests/support/source_file.h"

namespace tandem::test {

haptics::ArmParameters relaxedArm() { return {}; }
haptics::ArmParameters firmArm() { return {1.5, 300.0, 12.0, 800.0, 10.0}; }
haptics::ArmParameters lightArm() { return {1.46, 4.88, 4.5, 375.0, 7.9}; }

struct SharedSession::Loaded {
  client::Scenario scenario;
  assets::Scene scene;
  haptics::ContactScene contact;

  Loaded(client::Scenario described, assets::Scene loadedScene)
      : scenario(std::move(described)), scene(std::move(loadedScene)), contact(scene) {}
};

std::shared_ptr<const SharedSession::Loaded> SharedSession::load(const std::string& name, Contact contact,
                                                                 double massFactor) {
  static std::map<std::tuple<std::string, Contact, double>, std::shared_ptr<const Loaded>> made;
  std::shared_ptr<const Loaded>& entry = made[{name, contact, massFactor}];
  if (entry) return entry;
  const std::string path = sourceFile("tests/simulation/scenarios/") + name + ".json";
  Result<client::Scenario> loaded = client::loadScenario(path);
  EXPECT_TRUE(loaded.ok()) << (loaded.ok() ? "" : loaded.error().message);
  Result<assets::Scene> scene = assets::loadGltf(loaded->scene, loaded->load);
  EXPECT_TRUE(scene.ok()) << (scene.ok() ? "" : scene.error().message);
  for (assets::Part& part : scene->parts) {
    part.massProperties.mass *= massFactor;
    part.massProperties.inertia *= massFactor;
  }
  const auto session = std::make_shared<Loaded>(std::move(*loaded), std::move(*scene));
  if (contact == Contact::models) {
    EXPECT_TRUE(session->contact.modelParts());
  }
  entry = session;
  return entry;
}

SharedSession::SharedSession(const std::string& name, Contact contact, double massFactor)
    : loaded_(load(name, contact, massFactor)) {
  scenario = loaded_->scenario;
  options.leaderLoad = false;
}

void SharedSession::delayGrasp(std::size_t site, double seconds) {
  nlohmann::json script = nlohmann::json::parse(scenario.sites[site].script);
  for (auto& step : script)
    if (step["do"] == "grasp") step["t"] = step["t"].get<double>() + seconds;
  scenario.sites[site].script = script.dump();
}

client::SimulationResult SharedSession::run() const {
  Result<client::SimulationResult> result = client::simulate(scenario, loaded_->contact, options);
  EXPECT_TRUE(result.ok()) << (result.ok() ? "" : result.error().message);
  return std::move(*result);
}

double changeIn20ms(std::span<const glm::dvec3> force, std::size_t i) {
  double largest = 0.0;
  for (std::size_t back = 1; back <= std::min<std::size_t>(20, i); ++back)
    largest = std::max(largest, glm::length(force[i] - force[i - back]));
  return largest;
}

std::uint64_t sessions() {
  const char* text = std::getenv("TANDEM_SEEDS");
  return text != nullptr ? std::strtoull(text, nullptr, 10) : 1000;
}

std::uint64_t seedsUpTo(std::uint64_t max) {
  return atFullSize() ? max : std::clamp<std::uint64_t>(sessions() / 250, 1, max);
}

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
