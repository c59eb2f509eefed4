#pragma once

// Ties the parts that a site simulates to other sites' replicas of them: one coordination link per part and
// peer, and this replica's share of the part's mass.
//
// An owner has a link to each site that is engaged in its part; a guest has one link, to the owner. Both ends
// of a link are alike, so the owner of a part can change while the link goes on.
//
// 1. The room is fixed and nothing allocates. A part without links is unknown here and costs one comparison.
// 2. Nothing jumps: the force of a link that ends decays before the link is dropped, and masses ramp.
// 3. The thread that ticks calls pull() before a part moves and settle() after it, and everything else
//    between ticks.

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
  double delay = 0.0;   // s, the known network delay
  // Any number that this tie has at both ends and that no earlier tie between them had.
  std::uint32_t epoch = 0;
  /// Continues the same link under a new epoch without a felt change. Both ends must agree; a peer that lost
  /// its end may not.
  bool carriesOn = false;
  /// The outage spring (leash.h) leads the replica while the link does not carry it; for a guest's replica
  /// that no hand holds.
  bool leashed = false;
};

/// A packet to send to a peer.
struct TiedPacket {
  PartId part = kNoPart;
  SiteId peer = kNoSite;
  LinkPacket packet;
};

class TiedParts {
 public:
  static constexpr int kMaxTies = 16;
  /// Greatest delay, s, at which a guest's link is beneficial: for two hands on one part, and for a part of
  /// this site that touches another's, while they touch.
  static constexpr double kFarthestHeld = 0.15, kFarthestTouched = 0.35;

  /// Ties a part with this body, restarts an existing tie, or lets it carry on. False if there is no room.
  bool tie(const PartTie& tie, const RigidBody& body);
  /// Ends a tie: the force of the link decays, then the link is dropped; the peer is told meanwhile.
  void untie(PartId part, SiteId peer);
  /// Sets how many sites simulate a part, this one included. The replica's mass goes to its share, or to the
  /// whole mass without a live link.
  void setSimulators(PartId part, int simulators);
  /// Drops all links of a part at once, because this site no longer simulates it.
  void forget(PartId part);

  /// False if the packet was dropped or no such tie exists.
  bool receive(PartId part, SiteId peer, const LinkPacket& packet);
  /// Takes the packets that are due, about every packetPeriod, and returns their count; those that do not fit
  /// stay due.
  std::size_t takePackets(std::span<TiedPacket> packets);

  bool any() const { return sharedCount_ > 0; }
  bool has(PartId part) const { return sharedCount_ > 0 && find(part) != nullptr; }
  /// Begins the step of a tied part: ramps its mass, and returns the sum of its links' pulls. `now` is in s,
  /// session clock; `held` says that a hand here holds the part.
  LinkPull pull(PartId part, RigidBody& body, bool held, double now, double dt);
  /// The outage spring that leads a part while its link does not carry it, or null.
  const Leash* leash(PartId part) const;
  /// Ends the step with the velocity of the centre of mass and the spin that the body took, and the wrench of
  /// the outage spring.
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
    double sinceSent;     // s; nothing is due before the first step
  };
  /// A part with links, or whose mass is ramping back.
  struct Shared {
    PartId part = kNoPart;
    int simulators = 1;
    assets::MassProperties whole;
    MassRamp ramp;
    double share = 1.0;  // of the whole mass, towards which the replica's mass goes
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
