#pragma once

// Checks the rules of the ownership protocol (sync/README.md) on a simulated session from outside, and those
// of its doors (R1 to R5). It shares no code with the implementation: it sees the messages that sites receive
// and send, the states that they apply, and the server's record at each step.

#include <array>
#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "client/session/server_connection.h"
#include "sync/replica/lease_rules.h"
#include "sync/wire/ownership_messages.h"
#include "sync/wire/state_update.h"
#include "sync/wire/time.h"

namespace tandem::client {

/// S1 to S8 and L1 to L4 as in the design. R1: nobody does what his role forbids. R2: a token lets in once,
/// before it expires, if the server gave it. R3: the server answers no more than a site's budget. R4: who
/// sends what is no message of the protocol is parted from. R5: nobody doubts the motion of an honest site.
enum class Rule : std::uint8_t { S1, S2, S3, S4, S5, S6, S7, S8, L1, L2, L3, L4, R1, R2, R3, R4, R5 };
inline constexpr std::size_t kRules = 17;
const char* toString(Rule rule);

struct Violation {
  std::string rule;  // "S1" ... "R5"
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
  /// Anybody was told who owns a part, and may not believe it.
  void onTold(const sync::PartRecord& record);
  void onGrab(std::size_t site, const sync::Grab& grab);
  void onGrabReply(std::size_t site, const sync::GrabReply& reply);
  void onRelease(const sync::Release& release);
  void onAccepted(std::size_t site, const sync::PartState& state);
  void onPublished(SiteId self, const sync::PartState& state);
  void onConnection(std::size_t site, bool up);
  void onDead(std::size_t site, SiteId self);
  /// When the server last received what a dead client of this site had sent, whose lease that renews.
  void onHeardFromTheDead(std::size_t site, sync::Micros at);
  /// The site said goodbye: it publishes nothing more.
  void onLeft(std::size_t site, SiteId self);
  /// An instructor orders that the part be taken from its owner, who may not know yet and goes on; or that
  /// it be put back, if it is free.
  void onCommand(PartId part);
  /// The site's clock disagrees with the server's by more than the protocol bears: S3 does not hold for it
  /// now, and for the lease that runs.
  void onClockBeyondBound(SiteId self);

  // The server's record, after each of its steps, for each part that ever had an owner.
  void onServerRecord(const sync::PartRecord& record);
  /// All lists of co-holders, likewise.
  void onServerCoHolders(const std::vector<sync::CoHolderRecord>& lists);
  void onServerRestart(const std::vector<sync::PartRecord>& restored);
  /// The server stands still or cannot write, so that it frees nothing.
  void onServerHindered() { hinderedAt_ = now_; }
  /// A hostile peer is connected.
  void onStranger() { strangerAt_ = now_; }
  sync::Micros hinderedAt() const { return hinderedAt_; }

  /// Checks at the end of a run that every request was answered and that the replicas of each part agree
  /// (name of the part, largest distance between two sites in m).
  void finish(const std::vector<std::pair<std::string, double>>& replicaErrors);

  // For rules that are judged elsewhere.
  void checked(Rule rule) { ++checks_[static_cast<std::size_t>(rule)]; }
  void reportBroken(Rule rule, std::string what);

  const std::vector<Violation>& violations() const { return violations_; }
  /// How often each rule could have been found broken.
  const std::array<std::uint64_t, kRules>& checks() const { return checks_; }
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
  void checkHandOver(const sync::PartRecord& record);
  void checkDead(const sync::PartRecord& record);
  bool commandedOf(PartId part) const;
  bool heirIsGone(const sync::PartRecord& owned) const;

  sync::LeaseRules lease_;
  sync::Micros now_ = 0, restartedAt_ = -1, hinderedAt_ = -1, strangerAt_ = -1;
  std::vector<Violation> violations_;
  std::array<std::uint64_t, kRules> checks_{};
  std::vector<Grant> grants_;
  std::map<std::pair<PartId, Epoch>, SiteId> ownerOf_;  // S1
  std::map<PartId, sync::PartRecord> server_;           // as of the last step
  std::map<PartId, sync::PartRecord>
      restored_;  // from the journal at the last restart, less what was released
  std::vector<std::map<PartId, AppliedState>> applied_;               // S2, a site each
  std::map<std::tuple<PartId, Epoch, bool>, glm::dvec3> handedOver_;  // S6: with what pose; whether it ended
  std::map<SiteId, sync::Micros> beyondBoundAt_;                      // S3
  std::map<std::tuple<PartId, Epoch, std::uint32_t>, glm::dvec3>
      published_;                                    // S2: where states say a part is
  std::map<PartId, sync::Micros> commandedAt_;       // S3, R1
  std::vector<std::pair<PartId, Epoch>> takenAway_;  // R1, by no known command
  std::set<std::pair<PartId, Epoch>> released_;      // R1, whether or not the server knows yet
  std::map<PartId, sync::Micros> askerGoneAt_;       // R1, with its request unanswered
  struct OpenGrab {
    PartId part = kNoPart;
    sync::Micros at = 0;
  };
  std::vector<std::map<sync::RequestId, OpenGrab>> open_;                       // L1, a site each
  std::map<std::pair<std::size_t, sync::RequestId>, sync::GrabReply> answers_;  // S7
  struct Dead {
    std::size_t site = 0;
    sync::Micros since = 0;
  };
  std::map<SiteId, Dead> dead_;                 // L2
  std::vector<sync::Micros> heardFromTheDead_;  // L2, a site each
};

}  // namespace tandem::client
