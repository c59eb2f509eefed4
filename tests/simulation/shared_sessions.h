#pragma once

// Whole sessions on virtual time in which sites share parts: the scenarios beside this file, changed here and there.

#include <functional>
#include <string>

#include "client/simulation/simulation.h"

namespace tandem::test {

/// The laboratory's arms: relaxed, firm, and one that holds on but is easily led.
haptics::ArmParameters relaxedArm();
haptics::ArmParameters firmArm();
haptics::ArmParameters lightArm();

/// A scenario of this folder with its scene, whose parts collide.
class SharedSession {
 public:
  enum class Contact { models, none };  // whether held parts collide
  explicit SharedSession(const std::string& name, Contact contact = Contact::models);

  client::Scenario scenario;
  client::SimulationOptions options;
  client::SimulationResult run() const;
  const assets::Scene& scene() const { return contact_->scene(); }

  void setDelay(double milliseconds) {
    scenario.network.oneWay = static_cast<sync::Micros>(1e3 * milliseconds);
  }
  /// The hand of a site goes to its part later, s.
  void delayGrasp(std::size_t site, double seconds);
  haptics::ArmParameters& arm(std::size_t site) { return scenario.sites[site].arm; }

 private:
  assets::Scene scene_;
  std::shared_ptr<haptics::ContactScene> contact_;
};

/// How many sessions are drawn at random (TANDEM_SEEDS, else 1000); scenarios take a fiftieth of it as seeds, `most` at
/// most.
std::uint64_t sessions();
std::uint64_t seedsUpTo(std::uint64_t most);

/// What was broken, for messages.
std::string describe(const client::SimulationResult& result);

}  // namespace tandem::test
