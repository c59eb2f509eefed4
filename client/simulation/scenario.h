#pragma once

// A scenario of `tandem simulate`: people, devices, network and faults, read from JSON
// (client/simulation/README.md).

#include <string>
#include <vector>

#include "assets/base/result.h"
#include "assets/gltf/load_gltf.h"
#include "client/session/state_publisher.h"
#include "haptics/operator/simulated_hand.h"
#include "sync/transport/virtual_network.h"

namespace tandem::client {

struct ScenarioSite {
  std::string name;
  haptics::ArmParameters arm;
  haptics::SimulatedDeviceParameters device;
  bool fit = false;        // limits, stiffnesses and passivity control as in `tandem join` on such a device
  double stiffness = 0.0;  // N/m, of contacts and grasps, overrides `fit`; 0: not stated
  double deadband = PublishRates{}.deadband;  // Weber fraction of its published states
  std::string role = "participant";
  bool hasStart = false;
  glm::dvec3 start{0.0, 0.0, 0.0};  // m, world
  double joins = 0.0;               // s
  std::string script;               // JSON text, parsed against the scene later
};

struct Blackout {
  std::string site;
  double at = 0.0, lasts = 0.0;  // s
};

struct DelayStep {
  double at = 0.0;  // s
  sync::Micros oneWay = 0;
};

struct Fault {
  enum class Kind : std::uint8_t { killServer, pauseServer, killSite, pauseSite };
  Kind kind = Kind::killServer;
  double at = 0.0;      // s
  double lasts = -1.0;  // s: until the restart, or of the pause; < 0: for good
  std::string site;     // none: of the server

  bool ofServer() const { return kind == Kind::killServer || kind == Kind::pauseServer; }
};

struct Scenario {
  std::string path;   // of the scenario file, for messages
  std::string scene;  // path of the scene
  assets::LoadOptions load;
  double duration = 0.0;  // s
  std::vector<ScenarioSite> sites;
  sync::NetworkConditions network;
  double packetHz = 250.0;
  std::vector<Blackout> blackouts;
  std::vector<DelayStep> steps;
  std::vector<Fault> faults;
};

/// Reads a scenario file. The scene's path is taken from the file's folder, then from the working directory.
Result<Scenario> loadScenario(const std::string& path);

}  // namespace tandem::client
