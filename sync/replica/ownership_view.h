#pragma once

// A site's side of ownership: what it knows of who owns each part, what it may apply, and what it may
// publish. A pure state machine: no clock, no network, no thread.
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

  /// The co-holders from an EngageReply or a MembersChanged. False: not newer than the known ones; ignored.
  bool apply(const CoHolderRecord& coHolders);
  /// Before a Welcome: a server that was restarted counts the versions anew.
  void forgetCoHolders();
  const CoHolderRecord& coHolders(PartId part) const;
  bool isCoHolder(PartId part) const;
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

  /// A Pong arrived at local time `received` for a ping sent at local time `pingSent`, from which the lease
  /// now runs. If the lease had expired before, the server may have freed parts before the ping reached it,
  /// and the record of that may still be under way. Such parts must be reclaimed before they are published
  /// again (needsReclaim).
  void renewed(Micros pingSent, Micros received);
  /// The same without that check: S3 then holds only up to the delay of OwnershipChanged after a lapse (S2
  /// always does).
  void renewed(Micros pingSent);
  /// Whether this site holds the part by its own record, but the lease lapsed since the server last confirmed
  /// that.
  bool needsReclaim(PartId part) const;
  /// How often the lease has lapsed. A record or an answer may be read long after the server has ended the
  /// ownership in it, so only the answer to a request that was made since the last lapse confirms anything.
  std::uint32_t lapses() const;
  /// An EngageReply to such a request arrived: if the part then passes to this site, the site need not
  /// reclaim it.
  void coHoldingConfirmed(PartId part);
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
