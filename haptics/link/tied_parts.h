#pragma once

// What ties the parts that a site simulates to other sites' replicas of them: one coordination link a part and peer, and
// the share of the part's mass that the replica here has.
//
// An owner has a link to each site that is engaged in its part, a guest has one, to the owner; a link is the same at both
// ends, so that who owns the part may change and the link go on.
//
// 1. Room is fixed; nothing here allocates. A part without links is not known here and costs one comparison.
// 2. Nothing steps: a link that ends runs its force out before it is dropped, and masses ramp.
// 3. In the thread that ticks: pull() before a part moves, settle() after; everything else between ticks.

#include <array>
#include <optional>
#include <span>

#include "assets/base/ids.h"
#include "haptics/base/tick_types.h"
#include "haptics/link/coordination_link.h"
#include "haptics/link/leash.h"
#include "haptics/link/replica_mass.h"

namespace tandem::haptics {

/// What both ends must agree on before they tie their replicas.
struct PartTie {
  PartId part = kNoPart;
  SiteId peer = kNoSite;
  LinkParameters link;  // the same at both ends; `period` is the tick's
  double delay = 0.0;   // s, that the way is known to take
  std::uint32_t epoch =
      0;  // any number that this tie has at both ends, and that none between them had before
  /// The same link goes on under a new epoch: nothing is felt. Both ends must say so; a peer that lost its end may not.
  bool carriesOn = false;
  /// Where the link does not carry it, the replica is led to the peer's (leash.h): a guest's that no hand holds.
  bool leashed = false;
};

/// What is to be sent to a peer.
struct TiedPacket {
  PartId part = kNoPart;
  SiteId peer = kNoSite;
  LinkPacket packet;
};

class TiedParts {
 public:
  static constexpr int kMaxTies = 16;
  /// s, of delay, at which a guest's link still does more good than harm: two hands on one part, or a part of this site
  /// that touches another's, for as long as they touch.
  static constexpr double kFarthestHeld = 0.15, kFarthestTouched = 0.35;

  /// Ties a part whose body is this one, begins a tie that there is anew, or lets it carry on. False if there is no room.
  bool tie(const PartTie& tie, const RigidBody& body);
  /// The force of the link runs out, then it is dropped; the peer is told meanwhile.
  void untie(PartId part, SiteId peer);
  /// How many sites simulate a part, this one included: the replica's mass goes to its share. Without a live link it goes
  /// to all of it.
  void setSimulators(PartId part, int simulators);
  /// Drops all links of a part at once: it is not simulated here any more.
  void forget(PartId part);

  /// False if the packet was of no use, or there is no such tie.
  bool receive(PartId part, SiteId peer, const LinkPacket& packet);
  /// Those that are due, about every packetPeriod; what does not fit stays due. Returns how many.
  std::size_t takePackets(std::span<TiedPacket> packets);

  bool any() const { return sharedCount_ > 0; }
  bool has(PartId part) const { return sharedCount_ > 0 && find(part) != nullptr; }
  /// Begins the step of a part that is tied: ramps its mass, and says what its links put on it. `now` s, session clock;
  /// `held`: by a hand here.
  LinkPull pull(PartId part, RigidBody& body, bool held, double now, double dt);
  /// What leads a part while a link does not carry it, or null.
  const Leash* leash(PartId part) const;
  /// Ends it: the velocity of the centre of mass and the spin that the body took, and what led it, if anything did.
  void settle(PartId part, const RigidBody& body, const glm::dvec3& velocity, const glm::dvec3& spin,
              const Wrench& lead);
  TieReport report(PartId part) const;

 private:
  struct End {
    End(const PartTie& tie)
        : part(tie.part),
          peer(tie.peer),
          link(tie.link),
          parameters(tie.link),
          leashed(tie.leashed),
          sinceSent(tie.link.packetPeriod - tie.link.period) {}
    PartId part;
    SiteId peer;
    CoordinationLink link;
    LinkParameters parameters;
    bool leashed;
    Leash leash;
    Wrench acting, lead;  // of the last step
    double sinceSent;     // s; nothing is due before the first step: there is nothing to tell
  };
  /// A part with links, or whose mass is on its way back.
  struct Shared {
    PartId part = kNoPart;
    int simulators = 1;
    assets::MassProperties whole;
    MassRamp ramp;
    double share = 1.0;  // of the whole, that the replica goes to
  };

  std::optional<End>* slotOf(PartId part, SiteId peer);
  Shared* find(PartId part);
  const Shared* find(PartId part) const;
  template <typename F>
  void forEachEnd(PartId part, const F& f);
  assets::MassProperties shareOf(Shared& shared);
  void setMass(Shared& shared, RigidBody& body, double dt);
  void drop(Shared& shared);

  std::array<std::optional<End>, kMaxTies> ends_;
  std::array<Shared, kMaxOwnedParts> shared_;
  int sharedCount_ = 0;
  double now_ = 0.0;  // s, session clock, of the last step
};

}  // namespace tandem::haptics
