#pragma once

// Who owns which part: the rules S1-S8 of the protocol as two pure state machines, one for the server and one
// for a site. No clock, no network, no thread: time comes in as an argument, decisions come out as values.
//
// 1. A part has one owner or none. Every grant and every end of an ownership is published; a grant has a new
//    epoch, larger than any before it (S1), also across restarts (restore()).
// 2. Exclusion holds at the receiver: a state of another epoch or owner, or not newer, is dropped (S2).
// 3. Leases are for liveness. A site stops publishing when its lease, counted from the sending of the ping
//    that renewed it and shortened by the clocks' drift, has run out; the server frees the part only after
//    the full lease (S3).
// 4. A request repeated by (site, request id) gets the same answer again (S7), as long as it is among the
//    last kRememberedRequests of its site. An older one, or one from before a restart of the server, is
//    decided anew; that grants nothing twice, because a Grab by the owner is answered with the epoch that it
//    has.
// 5. After restore() no part gets a new owner, not even one that nobody owned, until each restored owner has
//    come back (reclaimed, released, left, or published in its epoch) or lease + drift has passed (S8).
// 6. A site that comes back with a ticket finds its parts in Welcome and reclaims or releases each: its pings
//    keep all of them.
// 7. Sites may be engaged in a part that another one owns. Their list is versioned (S5), and each is on it
//    for as long as its pings keep it there. Where the owner lets go, leaves or is no longer heard of, the
//    site that has been engaged for longest owns the part in the next epoch, so no simulated part is without
//    an owner.

// Order of records of one part: by epoch, and within an epoch an ended ownership (owner = kNoSite) after a
// running one. A grant, a revocation and a reset each begin a new epoch; a release, an expiry and a leave end
// the running one.

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "sync/wire/messages.h"
#include "sync/wire/time.h"

namespace tandem::sync {

struct LeaseRules {
  Micros lease = 2 * kSecond;
  double driftPpm = 500.0;            // by which two monotonic clocks may disagree
  Micros margin = 50 * kMillisecond;  // by which a site stops earlier than drift alone demands

  /// By how much two clocks may disagree about the length of a lease, rounded up.
  Micros drift() const { return static_cast<Micros>(static_cast<double>(lease) * driftPpm * 1e-6) + 1; }
  /// How long after the last renewal the server may free a part, and a site must have stopped.
  Micros serverLease() const { return lease + drift(); }
  Micros siteLease() const { return lease - drift() - margin; }
};

inline constexpr std::size_t kRememberedRequests = 64;  // a site

/// The server's side.
class OwnershipTable {
 public:
  /// movable[i]: whether part i may be granted. Poses at rest come from the scene.
  OwnershipTable(std::vector<bool> movable, std::vector<Pose> worldFromPartAtRest, LeaseRules rules);
  ~OwnershipTable();
  OwnershipTable(OwnershipTable&&) noexcept;

  /// Takes over what the journal kept. Owners have until `now` + lease (+ drift) to come back.
  void restore(std::span<const PartRecord> records, Micros now);

  struct Decision {
    GrabReply reply;
    bool changed = false;   // a new epoch: write it to the journal, then reply, then publish it
    bool repeated = false;  // an earlier answer, given again
  };
  Decision grab(SiteId site, Role role, const Grab& request, Micros now);
  Decision reclaim(SiteId site, Role role, const Reclaim& request, Micros now);

  struct ReleaseDecision {
    ReleaseReply reply;
    bool changed = false;
  };
  ReleaseDecision release(SiteId site, const Release& request);

  struct EngageDecision {
    EngageReply reply;
    bool changed = false;
  };
  EngageDecision engage(SiteId site, Role role, const Engage& request, Micros now);
  EngageDecision disengage(SiteId site, const Disengage& request);
  MemberRecord members(PartId part) const;
  /// Whether one of the two sites owns the part and the other one is engaged in it.
  bool tied(PartId part, SiteId a, SiteId b) const;
  /// Of every part that somebody is engaged in.
  std::vector<MemberRecord> allMembers() const;
  /// The lists that have changed since the last call, in order: to be published behind the part's own record.
  std::vector<MemberRecord> takeChangedMembers();

  /// Ends an ownership by an instructor's word, and all engagement, with a new epoch. Returns the part as it
  /// is now, or nothing if nobody owned it.
  std::optional<PartRecord> revoke(PartId part, Micros now);
  /// Puts a part that nobody owns back to its pose in the scene, with a new epoch; nothing if it is owned or
  /// was never granted.
  std::optional<PartRecord> reset(PartId part, Micros now);

  /// A site's ping arrived: all its leases run anew.
  void renew(SiteId site, Micros now);
  /// The site left for good: its parts are free now, or pass to a member. (A lost connection is not a leave:
  /// the lease decides.)
  std::vector<PartRecord> leave(SiteId site);
  /// Lease expiry: ends each ownership whose lease has run out, and returns the parts, free now or passed to
  /// a member. Sites that are no longer heard of are disengaged.
  std::vector<PartRecord> expire(Micros now);
  /// When the next lease runs out if it is not renewed; nothing if nobody owns a part.
  std::optional<Micros> nextExpiry() const;

  /// Whether a state that came from `site` may be relayed; if so its pose becomes the part's last known one
  /// (S2).
  bool accept(SiteId site, const PartState& state);

  const PartRecord& part(PartId part) const;
  /// Every part that was ever granted or moved.
  std::vector<PartRecord> records() const;
  bool recovering(Micros now) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// A site's side.
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
