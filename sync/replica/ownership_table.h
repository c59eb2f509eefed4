#pragma once

// The server's side of ownership: who owns which part, and who simulates it beside its owner. The rules S1 to
// S8 as a pure state machine: no clock, no network, no thread; time comes in as an argument, decisions come
// out as values.
//
// 1. A part has one owner or none. Every grant and every end of an ownership is published; a grant has a new
//    epoch, larger than any before it (S1), also across restarts (restore()).
// 2. Records of a part are ordered by epoch, and within an epoch an ended ownership (owner = kNoSite) comes
//    after a running one. A grant, a revocation and a reset each begin a new epoch; a release, an expiry and
//    a leave end the running one.
// 3. A request repeated by (site, request id) gets the same answer again (S7), as long as RequestMemory holds
//    it. An older one, or one from before a restart of the server, is decided anew; that grants nothing
//    twice, because a Grab by the owner is answered with the epoch that it has.
// 4. After restore() no part gets a new owner, not even one that nobody owned, until each restored owner has
//    come back (reclaimed, released, left, or published in its epoch) or lease + drift has passed (S8).
// 5. A site that comes back with a ticket finds its parts in Welcome and reclaims or releases each: its pings
//    keep all of them.
// 6. A part that is owned may have co-holders: sites that simulate it beside its owner. Their list is
//    versioned (S5), and the pings of a co-holder keep it on the list. Where the owner releases the part,
//    leaves or lets its lease expire, the longest co-holder owns the part in the next epoch, so no simulated
//    part is without an owner.

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "sync/replica/lease_rules.h"
#include "sync/wire/ownership_messages.h"
#include "sync/wire/participant_messages.h"
#include "sync/wire/state_update.h"

namespace tandem::sync {

class OwnershipTable {
 public:
  /// movable[i]: whether part i may be granted. Poses at rest come from the scene.
  OwnershipTable(std::vector<bool> movable, std::vector<Pose> worldFromPartAtRest, LeaseRules rules);
  ~OwnershipTable();
  OwnershipTable(OwnershipTable&&) noexcept;

  /// Takes over the records of the journal. Their owners have until `now` + lease + drift to come back. Every
  /// new epoch exceeds `floor`, below which epochs may have been told that the journal has lost.
  void restore(std::span<const PartRecord> records, Micros now, Epoch floor = 0);

  struct Decision {
    GrabReply reply;
    bool changed = false;   // a new epoch: write it to the journal, then reply, then publish it
    bool repeated = false;  // the earlier answer to the same request
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
  CoHolderRecord coHolders(PartId part) const;
  /// Whether one of the two sites owns the part and the other one is its co-holder, so that a coordination
  /// link joins their replicas.
  bool areLinked(PartId part, SiteId a, SiteId b) const;
  /// The co-holders of every part that has some.
  std::vector<CoHolderRecord> allCoHolders() const;
  /// The lists of co-holders that have changed since the last call, in order, to be published after the
  /// part's own record.
  std::vector<CoHolderRecord> drainChangedCoHolders();

  /// Ends an ownership at an instructor's command, with a new epoch, and removes all co-holders. Returns the
  /// part's record, or nothing if nobody owned it.
  std::optional<PartRecord> revoke(PartId part);
  /// Takes back a grant that its site was never told of: the part has no owner in a new epoch, and the site's
  /// request is decided anew if it is repeated. Nothing if the part has moved on since.
  std::optional<PartRecord> withdraw(const PartRecord& grant);
  /// Puts a part that nobody owns back to its pose in the scene, with a new epoch; nothing if it is owned or
  /// was never granted.
  std::optional<PartRecord> reset(PartId part);

  /// A site's ping arrived, which renews all its leases.
  void renew(SiteId site, Micros now);
  /// The site left for good: its parts are free now, or pass to a co-holder. A lost connection is not a
  /// leave; there the lease decides.
  std::vector<PartRecord> leave(SiteId site);
  /// Lease expiry: ends each ownership whose lease has expired, and returns the parts, which are free now or
  /// passed to a co-holder. Co-holders whose pings stopped are removed.
  std::vector<PartRecord> expire(Micros now);
  /// When the next lease expires if it is not renewed; nothing if nobody owns a part.
  std::optional<Micros> nextExpiry() const;

  /// Whether a state that arrived from `site` may be relayed; if so its pose becomes the last one of the
  /// part's record (S2).
  bool accept(SiteId site, const PartState& state);

  const PartRecord& part(PartId part) const;
  /// Every part that was ever granted or moved.
  std::vector<PartRecord> records() const;
  bool recovering(Micros now) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace tandem::sync
