#pragma once

// The server of a simulated session: the session that tandem-server runs, on a virtual network, a disk that
// can fail and clocks that can be wrong. It can be killed and started again.

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "client/simulation/drifting_clock.h"
#include "client/simulation/faulty_journal.h"
#include "client/simulation/simulation.h"
#include "server/session.h"
#include "sync/transport/virtual_network.h"

namespace tandem::client {

class SimulatedServer {
 public:
  /// `scene` and `network` must outlive this object.
  SimulatedServer(const assets::Scene& scene, sync::VirtualNetwork& network, std::uint64_t seed,
                  Mistake mistake);

  /// Starts the server process at virtual time `now`. `invariants` receives what the journal restored. If the
  /// journal is damaged, somebody recovers it first, and nobody's link or ticket is good any more.
  void start(sync::Micros now, Invariants& invariants);
  /// Ends the process. Records of the journal that were not durable yet are lost.
  void kill();
  bool running() const { return session_ != nullptr; }
  /// The process stands still until then.
  void pauseUntil(sync::Micros until) { pausedUntil_ = until; }
  bool paused(sync::Micros now) const { return now < pausedUntil_; }

  FaultyJournal& journal() { return journal_; }
  const FaultyJournal& journal() const { return journal_; }
  void setDrift(double ppm, sync::Micros now) { clock_.setDrift(ppm, now); }
  double drift() const { return clock_.drift(); }
  void stepWallClock(std::int64_t seconds);

  /// One step of a running server; `invariants` receives the record of every part that ever had an owner.
  void step(sync::Micros now, Invariants& invariants);
  /// When, in virtual time and not before `now`, step() must be called next even if nothing arrives.
  sync::Micros nextStep(sync::Micros now) const;
  /// Whether something has arrived that the server has not handled.
  bool hasEvents() const { return running() && sync::VirtualNetwork::hasEvents(*transport_); }

  /// A token with which a site may join in this role; empty while no server runs.
  std::string makeToken(const std::string& role) const;
  /// The same, which expires `seconds` from now, and one of another server.
  std::string makeToken(sync::Role role, std::int64_t seconds, sync::Micros now) const;
  std::string forgeToken(sync::Role role) const;
  /// What the wall clock of the server shows, and the least that it has shown since `since`: Unix time, s.
  std::int64_t unixNow(sync::Micros now) const;
  std::int64_t leastUnixSince(sync::Micros since) const;
  /// Null while no server runs.
  const server::Session* session() const { return session_.get(); }

 private:
  void observe(Invariants& invariants) const;

  const assets::Scene& scene_;
  sync::VirtualNetwork& network_;
  const Mistake mistake_;
  const std::vector<std::byte> package_;
  server::SigningKey key_;
  FaultyJournal journal_;
  std::unique_ptr<sync::Transport> transport_;
  std::unique_ptr<server::Session> session_;
  DriftingClock clock_;
  sync::Micros clockOffset_ = 0;  // session time less what the clock shows
  sync::Micros now_ = 0, pausedUntil_ = 0;
  struct WallClock {
    sync::Micros from;
    std::int64_t atZero;  // Unix time at virtual time 0
  };
  std::vector<WallClock> wallClocks_;  // one after the other
};

}  // namespace tandem::client
