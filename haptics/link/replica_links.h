#pragma once

// Coordination links of the parts that this site simulates: one for each part and peer, and this replica's
// share of the part's mass. It is the haptic thread's only record of links; the network thread's is PartLinks
// (client/session/part_links.h).
//
// The owner of a part has a link to each of its co-holders; a co-holder has one link, to the owner. Both ends
// of a link are alike, so the owner of a part can change while the link goes on.
//
// 1. The room is fixed and nothing allocates. A part without links is unknown here and costs one comparison.
// 2. Nothing jumps: the force of a link that ends decays before the link is dropped, and masses ramp.
// 3. The thread that ticks calls pull() before a part moves and account() after it, and everything else
//    between ticks.

#include <algorithm>
#include <array>
#include <optional>
#include <span>

#include "haptics/base/fixed_vector.h"
#include "haptics/base/tick_types.h"
#include "haptics/link/coordination_link.h"
#include "haptics/link/link_terms.h"
#include "haptics/link/outage_spring.h"
#include "haptics/link/replica_mass.h"

namespace tandem::haptics {

class ReplicaLinks {
 public:
  static constexpr int kMaxLinks = 16;

  /// Keeps the terms of a link until beginOrders() finds its part simulated; replaces an order for the same
  /// link. Without room the order is dropped: the peer is then alone with its replica.
  void order(const LinkTerms& terms);
  /// Calls `begin(terms)` for each order, oldest first, and drops the orders for which it returns true.
  template <typename Begin>
  void beginOrders(const Begin& begin) {
    dropOrders([&](const LinkTerms& terms) { return begin(terms); });
  }
  void cancelOrders(PartId part) {
    dropOrders([&](const LinkTerms& terms) { return terms.id.part == part; });
  }

  /// Begins a link of a part with this body, restarts an existing one, or lets it carry on. False if there is
  /// no room.
  bool begin(const LinkTerms& terms, const RigidBody& body);
  /// Ends a link or cancels its order. The force of the link decays, then the link is dropped; its packets
  /// tell the peer meanwhile.
  void end(LinkId link);
  /// Sets how many sites simulate a part, this one included. The replica's mass goes to its share, or to the
  /// whole mass without a live link.
  void setSimulators(PartId part, int simulators);
  /// Drops all links of a part at once, because this site no longer simulates it. Orders stay.
  void forget(PartId part);

  /// False if the packet was dropped or no such link exists.
  bool receive(const AddressedPacket& packet);
  /// Hands out the packets that are due, about every packetPeriod, and returns their count; those that do not
  /// fit stay due.
  std::size_t drainPackets(std::span<AddressedPacket> packets);

  /// Hands out the links whose peers have come to be doubted since the last call, and returns their count.
  std::size_t drainDoubts(std::span<LinkId> doubts);

  bool any() const { return !parts_.empty(); }
  bool has(PartId part) const { return any() && find(part) != nullptr; }
  /// Whether there is a link of the part, or an order for one.
  bool knows(PartId part) const;
  /// Whether a hand may close on the part: no link that has just begun has yet to take its replica over.
  bool carry(PartId part) const;
  struct Holding {
    bool held = false;     // by a hand here
    bool grasped = false;  // and its fingers have begun to close
  };
  /// Begins the step of a linked part: ramps its mass, and returns the sum of its links' pulls. `now` is in
  /// s, session clock.
  LinkPull pull(PartId part, RigidBody& body, Holding holding, double now, double dt);
  /// The longest play-out delay of a part's links that couple, s.
  double playOutDelay(PartId part) const;
  /// The outage spring that leads a part while its link does not carry it, or null.
  const OutageSpring* outageSpring(PartId part) const;
  /// Ends the step with the velocity of the centre of mass and the spin that the body took, and the wrench of
  /// the outage spring.
  void account(PartId part, const RigidBody& body, const glm::dvec3& velocity, const glm::dvec3& spin,
               const Wrench& outagePull);
  LinkReport report(PartId part) const;

 private:
  /// This site's end of a link.
  struct LinkEnd {
    explicit LinkEnd(const LinkTerms& given)
        : terms(given),
          link(given.parameters),
          sinceSent(given.parameters.packetPeriod - given.parameters.period) {}
    LinkTerms terms;  // of the first begin(); the present epoch and impedances are the link's own
    CoordinationLink link;
    OutageSpring outageSpring;
    Wrench acting, outagePull;  // of the last step
    double sinceSent;           // s; nothing is due before the first step
    double heardAt = 0.0;       // s, session clock: when it began, or its last packet arrived
    bool hasFadedIn = false;    // has begun to, at both ends
  };
  /// A part with links, or whose mass is ramping back.
  struct LinkedPart {
    PartId part = kNoPart;
    int simulators = 1;
    assets::MassProperties whole;
    MassRamp ramp;
    double share = 1.0;  // of the whole mass, towards which the replica's mass goes
  };

  template <typename Which>
  void dropOrders(const Which& which);
  std::optional<LinkEnd>* slotOf(LinkId link);
  LinkedPart* find(PartId part);
  const LinkedPart* find(PartId part) const;
  template <typename F>
  void forEachEnd(PartId part, const F& f);
  assets::MassProperties shareOf(LinkedPart& linked);
  void setMass(LinkedPart& linked, RigidBody& body, bool grasped, double dt);
  void drop(LinkedPart& linked);

  FixedVector<LinkTerms, kMaxLinks> orders_;            // of links that have yet to begin, oldest first
  std::array<std::optional<LinkEnd>, kMaxLinks> ends_;  // a link keeps its slot
  FixedVector<LinkedPart, kMaxOwnedParts> parts_;
  double now_ = 0.0;  // s, session clock, of the last step
};

template <typename Which>
void ReplicaLinks::dropOrders(const Which& which) {
  const auto end = std::remove_if(orders_.begin(), orders_.end(), which);
  for (auto left = orders_.end() - end; left > 0; --left) orders_.pop_back();
}

}  // namespace tandem::haptics
