#pragma once

// The server of a simulated session: the session that tandem-server runs, on a virtual network and with a
// journal in memory. It can be killed and started again.

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "client/simulation/simulation.h"
#include "server/memory_journal.h"
#include "server/session.h"
#include "sync/transport/virtual_network.h"

namespace tandem::client {

class SimulatedServer {
 public:
  /// `scene` and `network` must outlive this object.
  SimulatedServer(const assets::Scene& scene, sync::VirtualNetwork& network, std::uint64_t seed,
                  Mistake mistake);

  /// Starts the server process at virtual time `now`. `invariants` receives what the journal restored.
  void start(sync::Micros now, Invariants& invariants);
  /// Ends the process. Records of the journal that were not durable yet are lost.
  void kill();
  bool running() const { return session_ != nullptr; }

  /// Advances the journal's disk, which goes on while no server runs.
  void advanceJournalTo(sync::Micros now) { journal_.advanceTo(now); }
  /// One step of a running server; `invariants` receives the record of every part that ever had an owner.
  void step(sync::Micros now, Invariants& invariants);

  /// A token with which a site may join in this role; empty while no server runs.
  std::string makeToken(const std::string& role) const;

 private:
  const assets::Scene& scene_;
  sync::VirtualNetwork& network_;
  const Mistake mistake_;
  const std::vector<std::byte> package_;
  server::SigningKey key_;
  server::MemoryJournal journal_;
  std::unique_ptr<sync::Transport> transport_;
  std::unique_ptr<server::Session> session_;
  sync::Micros clockOffset_ = 0;  // session time less virtual time
};

}  // namespace tandem::client
