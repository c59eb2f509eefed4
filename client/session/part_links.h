#pragma once

// The network thread's record of the coordination links that couple this site's replicas of parts to those of
// other sites. Ownership decides which links there are; the haptic thread's record is ReplicaLinks
// (haptics/link/replica_links.h), which receives the same terms by events.
//
// 1. The owner of a part begins a link to each of its co-holders, and chooses its terms and its epoch. The
//    co-holder takes both from the first packet that it receives.
// 2. Between two sites a later link of a part has a larger epoch, whichever of them begins it. Epochs follow
//    the session's clock; those of different peers are not compared, because the peers' clocks may disagree.
//    The owner begins a link anew after kSilence without a packet: the other end may have forgotten it.
// 3. Orders to the hand leave as events, in the order in which they were decided.
//
// Network thread.

#include <cstdint>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "assets/scene/scene.h"
#include "client/session/exchange.h"
#include "sync/replica/ownership_view.h"
#include "sync/wire/link_stream.h"
#include "sync/wire/link_update.h"
#include "sync/wire/time.h"

namespace tandem::client {

class PartLinks {
 public:
  /// The scene must outlive this. `packetPeriod` s, of the links that this site begins.
  PartLinks(const assets::Scene& scene, double packetPeriod);

  /// Notes that a state of `peer` was `age` old when it came.
  void noteAge(SiteId peer, sync::Micros age);
  /// Ends the links of a part to sites that do not hold it any more. The part's owner also begins those that
  /// are missing. `now`: session time.
  void follow(const sync::OwnershipView& view, PartId part, sync::Micros now);
  /// Begins anew the links of this site's own parts that have fallen silent.
  void beginSilentAnew(const sync::OwnershipView& view, sync::Micros now);

  /// A packet for the hand; nothing if the datagram belongs to no link, or to an earlier epoch. `now`:
  /// session time.
  std::optional<haptics::AddressedPacket> receive(const sync::LinkUpdate& update,
                                                  const sync::OwnershipView& view, sync::Micros now);
  /// A packet for the wire; nothing if its link has ended.
  std::optional<sync::LinkUpdate> toWire(const haptics::AddressedPacket& packet) const;

  /// Whether what the peer does to the part is felt here: there is a link, and its delay is not too
  /// long.
  bool felt(PartId part, SiteId peer) const;

  /// The orders to the hand since the last call.
  std::vector<NetworkEvent> drainEvents();

  static constexpr sync::Micros kSilence = 1500 * sync::kMillisecond;

 private:
  struct Link {
    haptics::LinkTerms terms;
    sync::LinkReceiver receiver;
    sync::Micros receivedAt = 0;  // session time, of the newest packet
    bool felt = false;            // as the peer measures the delay
  };
  struct Age {
    SiteId site = kNoSite;
    double seconds = 0.0;  // low-passed
  };

  Link* find(haptics::LinkId id);
  const Link* find(haptics::LinkId id) const;
  Link& add(haptics::LinkId id);
  double ageOf(SiteId peer) const;
  std::uint32_t newEpoch(PartId part, sync::Micros now);
  sync::LinkAgreement agreementWith(SiteId peer, std::size_t links) const;
  void begin(Link& link, std::uint32_t epoch, const sync::LinkAgreement& agreement, sync::Micros now,
             bool ownedByPeer);
  void linkCoHolders(PartId part, const std::vector<SiteId>& coHolders, sync::Micros now);
  void publishSimulators(const sync::OwnershipView& view, PartId part);
  Link* linkToOwner(const sync::LinkUpdate& update, sync::Micros now);

  const assets::Scene& scene_;
  double packetPeriod_;
  std::vector<Link> links_;
  std::vector<Age> ages_;
  std::vector<std::uint32_t> lastEpoch_;                      // by part, of any of its links
  std::map<std::pair<PartId, SiteId>, std::uint32_t> begun_;  // epoch of the newest link with each peer
  std::vector<NetworkEvent> events_;
};

}  // namespace tandem::client
