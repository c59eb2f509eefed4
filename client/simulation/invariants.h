#pragma once

// Checks the rules of the ownership protocol (sync/README.md) on a simulated session from outside: S1-S4, S7,
// S8, L1, L2 and L4; S6 shows as S2. It shares no code with the implementation: it sees the messages that
// sites receive and send, the states that they apply, and the server's record at each instant.

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
  std::string what;  // the part, epoch and sites
};

class Invariants {
 public:
  Invariants(std::size_t sites, sync::LeaseRules lease);

  /// Virtual time never goes back.
  void setTime(sync::Micros now);

  // Messages of a site. `site` is its index in the scenario, `self` its id in the session.
  void onOwnership(std::size_t site, const sync::PartRecord& record);
  void onGrab(std::size_t site, const sync::Grab& grab);
  void onGrabReply(std::size_t site, const sync::GrabReply& reply);
  void onRelease(const sync::Release& release);
  void onAccepted(std::size_t site, const sync::PartState& state);
  void onPublished(SiteId self, const sync::PartState& state);
  void onConnection(std::size_t site, bool up);
  void onDead(std::size_t site, SiteId self);

  // The server's record, once a tick for each part that ever had an owner.
  void onServerRecord(const sync::PartRecord& record);
  void onServerRestart(const std::vector<sync::PartRecord>& restored);

  /// Checks at the end of a run that every request was answered and that the replicas of each part agree
  /// (name of the part, largest distance between two sites in m).
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
  /// The newest state that a site has applied to a part.
  struct AppliedState {
    Epoch epoch = 0;
    std::uint32_t sequence = 0;
  };
  void reportBroken(const char* rule, std::string what);

  sync::LeaseRules lease_;
  sync::Micros now_ = 0, restartedAt_ = -1;
  std::vector<Violation> violations_;
  std::vector<Grant> grants_;
  std::map<std::pair<PartId, Epoch>, SiteId> ownerOf_;  // S1
  std::map<PartId, sync::PartRecord> server_;           // as of the last tick
  std::map<PartId, sync::PartRecord>
      restored_;  // from the journal at the last restart, less what was released
  std::vector<std::map<PartId, AppliedState>> applied_;  // S2, a site each
  struct OpenGrab {
    PartId part = kNoPart;
    sync::Micros at = 0;
  };
  std::vector<std::map<sync::RequestId, OpenGrab>> open_;                       // L1, a site each
  std::map<std::pair<std::size_t, sync::RequestId>, sync::GrabReply> answers_;  // S7
  std::map<SiteId, sync::Micros> deadSince_;                                    // L2
};

}  // namespace tandem::client
