#pragma once

// A site's side of ownership: what it knows of who owns each part, what it may apply, and what it may publish.
// A pure state machine: no clock, no network, no thread.
//
// 1. Exclusion holds at the receiver: a state of another epoch or owner, or not newer, is dropped (S2).
// 2. A site stops publishing when its lease, counted from the sending of the ping that renewed it, has run
//    out (S3; lease_rules.h).

#include <cstdint>
#include <memory>

#include "sync/replica/lease_rules.h"
#include "sync/wire/ownership_messages.h"
#include "sync/wire/state_update.h"

namespace tandem::sync {

class OwnershipView {
 public:
  OwnershipView(std::size_t partCount, LeaseRules rules);
  ~OwnershipView();
  OwnershipView(OwnershipView&&) noexcept;

  void setSelf(SiteId self);
  SiteId self() const;

  /// A record from a Welcome, an OwnershipChanged or a GrabReply. False: not newer than what is known;
  /// ignored.
  bool apply(const PartRecord& record);

  /// Members from an EngageReply or a MembersChanged. False: not newer than what is known; ignored.
  bool apply(const MemberRecord& members);
  /// Before a Welcome: a server that was started again counts its versions anew.
  void forgetMembers();
  const MemberRecord& members(PartId part) const;
  bool engaged(PartId part) const;
  /// The number of sites that simulate the part, its owner included: each has a replica of 1/n of its mass.
  std::size_t simulators(PartId part) const;

  enum class Verdict : std::uint8_t {
    accepted,
    oldEpoch,
    futureEpoch,
    notOwner,
    oldSequence,
    ownPart,
    unknownPart
  };
  /// Whether a state from `from` may be used here (S2).
  Verdict accept(SiteId from, const PartState& state);

  /// A Pong arrived for a ping sent at local time `pingSent`: the lease now ends that much later. `received`
  /// is the pong's own local time. If the lease had run out by then, the server may have freed parts before
  /// the ping reached it, and the word of that may still be under way: such parts must be reclaimed before
  /// they are published again (needsReclaim).
  void renewed(Micros pingSent, Micros received);
  /// The same without that check: S3 then holds only up to the delay of OwnershipChanged after a lapse (S2
  /// always does).
  void renewed(Micros pingSent);
  /// Whether this site holds the part by its own record, but the lease lapsed since the server last confirmed
  /// that.
  bool needsReclaim(PartId part) const;
  /// How often the lease has lapsed. A record or an answer may be read long after the server has ended what
  /// it says, so only the answer to what was asked since the last lapse confirms anything.
  std::uint32_t lapses() const;
  /// An EngageReply to such a request arrived: if the part then passes to this site, it need not reclaim it.
  void engagementConfirmed(PartId part);
  /// A GrabReply to such a request granted the part to this site in this epoch.
  void confirmed(PartId part, Epoch epoch);
  /// Whether this site may publish states of a part that it owns at local time `now` (S3).
  bool mayPublish(PartId part, Micros now) const;
  bool leaseValid(Micros now) const;

  const PartRecord& part(PartId part) const;
  bool owns(PartId part) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace tandem::sync
