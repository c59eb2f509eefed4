#pragma once

// A whole session in one process on virtual time: the server's session, the wire, ownership, sites and haptic
// loops are the code that runs over sockets; clocks, network, disk, arms and devices are models. The same
// scenario and seed give the same result to the bit.

#include <cstdint>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "client/simulation/invariants.h"
#include "client/simulation/scenario.h"
#include "haptics/scene/contact_scene.h"

namespace tandem::client {

struct SimulatedSiteResult {
  double energyCreated = 0.0;                           // J, this hand's part (created_energy.h)
  double feltStiffness = 0.0;                           // N/m, 0 if nothing fixed was pressed
  double forceStep20ms = 0.0;                           // N
  double handoverExcess = 0.0;                          // N
  double rmsForce = 0.0, maxForce = 0.0;                // N
  double packetsPerSecond = 0.0, bytesPerSecond = 0.0;  // sent
  bool calm = true;                                     // HandMeasures::calm()
  bool pushed = false;                                  // others pushed a part against this hand's bare tool
  sync::Traffic sent;                                   // over the whole time
  std::uint64_t reconnects = 0;                         // connections lost, since the site last started
};

struct SimulationResult {
  bool stable = true;
  std::map<std::string, SimulatedSiteResult> sites;
  double displayedRms = 0.0, displayedMax = 0.0;      // m, owner's part against the display poses of others
  double discrepancyRms = 0.0, discrepancyMax = 0.0;  // m, owner's replica against those of co-holders
  double shared = 0.0;                                // s, for which a part had co-holders
  double energyCreated = 0.0;                         // J, over all sites (created_energy.h)
  double energyOfLinks = 0.0;  // J, the largest energy that all links together had created at any time
  double leaderLoadRatio = 1.0;
  std::vector<Invariants::Grant> grants;
  std::map<SiteId, std::string> siteNames;
  std::vector<std::string> partNames;
  std::vector<Violation> violations;
  std::map<std::string, Pose>
      finalPoses;  // by part, of parts that were ever granted, as the first live site has them
  std::uint64_t droppedStates = 0, denials = 0;
  std::string hash;  // of every pose and force of every tick
};

/// A site after a tick, in the order of the scenario.
struct SimulatedSiteState {
  glm::dvec3 device{0.0, 0.0, 0.0};  // m, where the device is
  glm::dvec3 force{0.0, 0.0, 0.0};   // N, what it gives
  const haptics::TickOutput* tick = nullptr;
};

/// A deliberate mistake, to check that invariants and measures detect it.
enum class Mistake : std::uint8_t {
  none,
  journalForgotten,  // a restarted server knows no epoch
  regrantedEarly,    // the server frees a part after a tenth of its owner's lease
  negativeDamping,   // every device pushes its hand along, with 0.5 N·s/m: a source of energy
  doubtsAtOnce,      // sites doubt at a two hundredth of what is odd
  limitsUnknown,     // ticks do not know what their device can give, nor limit what peers do to it
  torqueUnknown,     // ticks do not know how hard their hand may turn what others hold too
  linksLie,          // the link packets of the second site lie (LinkLie)
  linksLieBelieved,  // so, and nobody limits what peers do to them
};

/// With linksLie: the second site says that it pushes with about 30 N.
struct LinkLie {
  glm::dvec3 along{1.0, 0.0, 0.0};  // unit, world axes
  double from = 0.0;                // s, session clock
  double hertz = 0.0;               // how often a second the push changes to and fro; 0: never
};

struct SimulationOptions {
  std::uint64_t seed = 1;
  Mistake mistake = Mistake::none;
  LinkLie lie;
  std::function<void(double t, std::span<const SimulatedSiteState>)> watch;  // called after each tick
  std::string tracePath;                                                     // empty: no trace
  bool leaderLoad = true;  // runs the scenario again without delay, for the ratio
};

/// Runs the scenario on the scene of `contact`. Held parts collide if their models were made
/// (ContactScene::modelParts()).
Result<SimulationResult> simulate(const Scenario& scenario, const haptics::ContactScene& contact,
                                  const SimulationOptions& options);

/// The result in the form of `tandem simulate --json`.
std::string toJson(const SimulationResult& result);

}  // namespace tandem::client
