#pragma once

// A whole session of the protocol alone on virtual time: the server's session, the wire, ownership and the
// sites' connections are the code that runs over sockets; hands have no haptics (light_hand.h). Time jumps
// from one millisecond in which something is due to the next. The same scenario and seed give the same result
// to the bit.

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "client/simulation/invariants.h"
#include "client/simulation/scenario.h"
#include "client/simulation/simulation.h"
#include "server/session_context.h"

namespace tandem::client {

class ExchangePool;

struct ProtocolResult {
  std::vector<Violation> violations;
  std::array<std::uint64_t, kRules> checks{};  // how often each rule could have been found broken
  std::vector<Invariants::Grant> grants;
  server::SessionCounters server;  // of the last server process
  std::uint64_t steps = 0;         // instants at which something was due
  std::uint64_t serverSteps = 0, siteSteps = 0;
  std::uint64_t granted = 0;                                       // grabs of hands, as owner or co-holder
  std::uint64_t reconnects = 0, droppedStates = 0, malformed = 0;  // of sites that were there at the end
  std::string hash;  // of every grant and state that was applied
};

/// Runs scenarios on one scene. One thread.
class ProtocolSimulation {
 public:
  /// The scene must outlive this object.
  explicit ProtocolSimulation(const assets::Scene& scene, Mistake mistake = Mistake::none);
  ~ProtocolSimulation();
  /// The scripts of the scenario must be good (parseHandScript()).
  Result<ProtocolResult> run(const Scenario& scenario, std::uint64_t seed);

 private:
  class Run;
  const assets::Scene& scene_;
  const Mistake mistake_;
  std::unique_ptr<ExchangePool> pool_;
};

/// The result as JSON.
std::string toJson(const ProtocolResult& result);

}  // namespace tandem::client
