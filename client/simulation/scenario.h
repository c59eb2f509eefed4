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

/// One thing that goes wrong, or that somebody does. Each ends by itself after `lasts`, or lasts on.
struct Fault {
  enum class Kind : std::uint8_t {
    killServer,   // and start it again when it is over
    pauseServer,  //
    killSite,     // and start it again when it is over
    pauseSite,    //
    leave,        // the site says goodbye
    revoke,       // the site orders that `part` be taken from its owner
    reset,        // the site orders that all free parts be put back
    diskFails,    // nothing becomes durable, and the journal says so
    diskSlow,     // `amount` s until a record is durable
    diskTears,    // the record under way is half on the disk when the server is killed
    diskRots,     // a record that is on the disk cannot be read when the server starts next
    diskLies,     // what it calls durable is lost if the server is killed meanwhile
    drift,        // the monotonic clock of the site, or of the server, runs `amount` ppm fast
    wallStep,     // the server's wall clock is put forward by `amount` s
    cutUp,        // nothing of the site reaches the server
    cutDown,      // nothing of the server reaches the site
    delay,        // `amount` s more each way
    burst,        // `amount` of the datagrams of the site, or of all, are lost
    uplink,       // the site sends no more than `amount` bytes/s
    malformed,    // a stranger enters and sends bytes that are no messages
    replay,       // a stranger enters twice with one token, and sends old messages again
    escalate,     // a stranger enters and does what its role may not do
    flood,        // a stranger enters and sends far more than it may
    forge,        // a stranger tries tokens that the server never gave, or that have expired
  };
  Kind kind = Kind::killServer;
  double at = 0.0;      // s
  double lasts = -1.0;  // s; < 0: for good
  std::string site{};   // none: of the server, of all sites, or of a stranger
  double amount = 0.0;  // ppm, s, share or bytes/s
  std::string part{};   // of a revoke

  bool ofServer() const { return kind == Kind::killServer || kind == Kind::pauseServer; }
  /// What somebody does by right, which goes on when nothing goes wrong any more.
  bool isDeed() const { return kind == Kind::leave || kind == Kind::revoke || kind == Kind::reset; }
  bool ofStranger() const { return kind >= Kind::malformed; }
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
  /// From here on nothing goes wrong any more: the network is perfect, the server runs on a good disk, clocks
  /// are right; s, < 0: never.
  double calmFrom = -1.0;
};

/// The scenario as JSON that loadScenario() reads, with the name of its scene instead of its path.
std::string toJson(const Scenario& scenario);

/// Reads a scenario file. The scene's path is taken from the file's folder, then from the working directory.
Result<Scenario> loadScenario(const std::string& path);

}  // namespace tandem::client
