#pragma once

// Sessions on virtual time in which sites share parts. They run the scenarios of this folder, which a test
// changes where it needs to.

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include <glm/vec3.hpp>

#include "client/simulation/simulation.h"

namespace tandem::test {

/// Arms of three people: relaxed, firm, and one that holds on but is easily led.
haptics::ArmParameters relaxedArm();
haptics::ArmParameters firmArm();
haptics::ArmParameters lightArm();

/// A scenario of this folder with its scene. The scene and its contact models are made once a process for
/// each scenario, and shared by all sessions of it.
class SharedSession {
 public:
  enum class Contact { models, none };  // with models, held parts collide
  /// `massFactor`: by which all movable parts are heavier than in the scene.
  explicit SharedSession(const std::string& name, Contact contact = Contact::models, double massFactor = 1.0);

  client::Scenario scenario;
  client::SimulationOptions options;
  client::SimulationResult run() const;

  void setDelay(double milliseconds) {
    scenario.network.oneWay = static_cast<sync::Micros>(1e3 * milliseconds);
  }
  /// Delays the grasps in a site's script by `seconds`.
  void delayGrasp(std::size_t site, double seconds);
  haptics::ArmParameters& arm(std::size_t site) { return scenario.sites[site].arm; }

 private:
  struct Loaded;
  static std::shared_ptr<const Loaded> load(const std::string& name, Contact contact, double massFactor);
  std::shared_ptr<const Loaded> loaded_;
};

/// The largest change, N, of a force (N, world axes, one entry for each tick of 1 ms) within the 20 ms that
/// end with entry `i`.
double changeIn20ms(std::span<const glm::dvec3> force, std::size_t i);

/// How many sessions are drawn at random: TANDEM_SEEDS, or 1000.
std::uint64_t sessions();
/// How many seeds a scenario runs with: `max` with TANDEM_FULL_SIZE, else sessions() / 250, from 1 to `max`.
std::uint64_t seedsUpTo(std::uint64_t max);

/// The broken rules and the grants of a run, for messages.
std::string describe(const client::SimulationResult& result);

}  // namespace tandem::test
