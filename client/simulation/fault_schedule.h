#pragma once

// The faults of a scenario, applied when their time has come and taken back when it is over. Both simulations
// use it: the one with hands, a millisecond a step, and the one of the protocol alone.

#include <memory>
#include <string>
#include <vector>

#include "client/simulation/invariants.h"
#include "client/simulation/scenario.h"
#include "client/simulation/simulated_server.h"
#include "client/simulation/stranger.h"
#include "sync/transport/virtual_network.h"

namespace tandem::client {

/// A site to which things happen.
class FaultySite {
 public:
  virtual ~FaultySite() = default;
  virtual const std::string& name() const = 0;
  virtual bool started() const = 0;
  /// Ends the client at once. What it knew is lost.
  virtual void crash() = 0;
  /// Starts the client: from now on it connects.
  virtual void start() = 0;
  virtual void pauseUntil(sync::Micros until) = 0;
  virtual void setDrift(double ppm, sync::Micros now) = 0;
  virtual void leave() = 0;
  virtual void revoke(PartId part) = 0;
  virtual void resetParts() = 0;
};

class FaultSchedule {
 public:
  /// All that is referred to outlives this.
  FaultSchedule(const Scenario& scenario, const assets::Scene& scene, sync::VirtualNetwork& network,
                SimulatedServer& server, Invariants& invariants, std::uint64_t seed);

  void addSite(FaultySite& site) { sites_.push_back(&site); }

  /// Applies what is due; time does not go back.
  void advanceTo(sync::Micros now);
  /// When something is due next; `never` if nothing is.
  sync::Micros nextDue(sync::Micros never) const;
  /// Whether nothing goes wrong any more.
  bool calm() const { return calm_; }

 private:
  struct Entry {
    sync::Micros at = 0;
    std::size_t fault = 0;
    bool ends = false;
  };
  void apply(const Fault& fault);
  void applyToServer(const Fault& fault);
  void applyToSite(const Fault& fault);
  void applyToDisk(const Fault& fault, bool ends);
  void applyToNetwork(const Fault& fault, bool ends);
  void setDrift(const std::string& site, double ppm);
  void end(const Fault& fault);
  void hearTheDead();
  void restart();
  void applyNetworkSteps();
  void becomeCalm();
  sync::Micros untilOf(const Fault& fault) const;
  FaultySite* find(const std::string& name);

  const Scenario& scenario_;
  const assets::Scene& scene_;
  sync::VirtualNetwork& network_;
  SimulatedServer& server_;
  Invariants& invariants_;
  std::uint64_t seed_;
  std::vector<FaultySite*> sites_;
  std::vector<Entry> due_;  // the latest first
  std::vector<std::unique_ptr<Stranger>> strangers_;
  sync::NetworkConditions conditions_;
  sync::Micros now_ = 0, serverRestartsAt_ = -1;
  std::uint64_t heardFromTheDead_ = 0;
  std::vector<bool> blackoutDone_, stepDone_;                 // an entry of the scenario each
  std::vector<std::pair<sync::Micros, FaultySite*>> rejoin_;  // when which site starts again; < 0: done
  bool calm_ = false;
};

}  // namespace tandem::client
