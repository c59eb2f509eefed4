#pragma once

// Watches a simulated session from outside and says which promises of the protocol were broken: S1-S4, S6-S8,
// L1, L2, L4 of the design. Knows nothing of how ownership is implemented: it sees what sites were told, sent
// and applied, and what the server's record says at each instant.

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "client/session/server_connection.h"
#include "sync/replica/lease_rules.h"
#include "sync/wire/ownership_messages.h"
#include "sync/wire/state_update.h"
#include "sync/wire/time.h"

namespace tandem::client {

struct Violation {
  std::string rule;  // "S1" ... "L4"
  double at = 0.0;   // s, virtual time
  std::string what;
};

class Invariants {
 public:
  Invariants(std::size_t sites, sync::LeaseRules lease);

  void setTime(sync::Micros now) { now_ = now; }

  // what a site (by index in the scenario) sees and does
  void onOwnership(std::size_t site, const sync::PartRecord& record);
  void onGrab(std::size_t site, const sync::Grab& grab);
  void onGrabReply(std::size_t site, const sync::GrabReply& reply);
  void onRelease(const sync::Release& release);
  void onAccepted(std::size_t site, const sync::PartState& state);
  void onPublished(std::size_t site, SiteId self, const sync::PartState& state);
  void onConnection(std::size_t site, bool up);
  void onDead(std::size_t site, SiteId self);

  // what the server's record says, once a tick, for parts that ever had an owner
  void onServerRecord(const sync::PartRecord& record);
  void onServerRestart(const std::vector<sync::PartRecord>& restored);

  /// At the end: unanswered requests, parts of the dead that stay owned, replicas that differ.
  void finish(const std::vector<std::pair<std::string, double>>& replicaErrors);

  const std::vector<Violation>& violations() const { return violations_; }
  struct Grant {
    double at = 0.0;
    PartId part = kNoPart;
    SiteId site = kNoSite;
    Epoch epoch = 0;
  };
  const std::vector<Grant>& grants() const { return grants_; }

 private:
  struct SeenPart {
    Epoch epoch = 0;
    std::uint32_t sequence = 0;
  };
  void broken(const char* rule, std::string what);

  sync::LeaseRules lease_;
  sync::Micros now_ = 0, restartedAt_ = -1;
  std::vector<Violation> violations_;
  std::vector<Grant> grants_;
  std::map<std::pair<PartId, Epoch>, SiteId> ownerOf_;  // S1
  std::map<PartId, sync::PartRecord> server_;
  std::map<PartId, sync::PartRecord> restored_;
  std::vector<std::map<PartId, SeenPart>> seen_;  // S2, a site each
  struct OpenGrab {
    PartId part = kNoPart;
    sync::Micros at = 0;
  };
  std::vector<std::map<sync::RequestId, OpenGrab>> open_;                       // L1, a site each
  std::map<std::pair<std::size_t, sync::RequestId>, sync::GrabReply> answers_;  // S7
  std::map<SiteId, sync::Micros> deadSince_;                                    // L2
};

}  // namespace tandem::client
