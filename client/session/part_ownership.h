#pragma once

// The owner and the co-holders of each part, as the server publishes them, and what follows: the coordination
// links between them (part_links.h), and the packets of those links between the hand and the wire.
//
// 1. Every change of ownership reaches the hand as an event, before the orders to its links that follow from
//    it.
//
// Network thread.

#include "client/session/connection_observer.h"
#include "client/session/hand_events.h"
#include "client/session/message_sender.h"
#include "client/session/part_links.h"
#include "client/session/session_clock.h"
#include "sync/replica/lease_rules.h"
#include "sync/replica/ownership_view.h"
#include "sync/wire/link_update.h"
#include "sync/wire/ownership_messages.h"
#include "sync/wire/time.h"

namespace tandem::client {

class PartOwnership {
 public:
  /// What is referred to must outlive this. `packetRate` in Hz, of the links that this site begins.
  PartOwnership(const assets::Scene& scene, const sync::LeaseRules& lease, double packetRate,
                Exchange& exchange, HandEvents& events, MessageSender& sender, SessionClock& clock,
                const Watchers& watchers);

  /// A Welcome arrived: this site is `self`, and the server may count the versions of co-holders anew.
  void enter(SiteId self);
  /// False if there is no such part.
  [[nodiscard]] bool handle(const sync::OwnershipChanged& message);
  void handle(const sync::MembersChanged& message);
  void handle(const sync::LinkUpdate& update);
  /// Records of parts that exist; one that is not newer than what is known is ignored.
  void apply(const sync::PartRecord& record);
  void apply(const sync::CoHolderRecord& coHolders);

  /// A state of `peer` arrived `age` after the time at which it held.
  void noteAge(SiteId peer, sync::Micros age) { links_.noteAge(peer, age); }
  /// Sends the packets of the hand's ends of links, and begins links anew that have fallen silent.
  void exchangeLinks();
  /// Whether a link's packet leaves so soon that other state messages should wait to ride on its datagram.
  bool linkPacketIsNear() const;
  /// Whether the peer's forces on the part are felt here through a link.
  bool felt(PartId part, SiteId peer) const { return links_.felt(part, peer); }

  sync::OwnershipView& view() { return view_; }
  const sync::OwnershipView& view() const { return view_; }
  bool exists(PartId part) const { return part < scene_.parts.size(); }
  const assets::Scene& scene() const { return scene_; }
  const sync::WireFrame& frame() const { return frame_; }

 private:
  void followLinks(PartId part);
  void pushOrders();

  const assets::Scene& scene_;
  Exchange& exchange_;
  HandEvents& events_;
  MessageSender& sender_;
  SessionClock& clock_;
  const Watchers& watchers_;
  sync::WireFrame frame_;
  sync::OwnershipView view_;
  PartLinks links_;
  sync::Micros patience_;                     // for which other messages wait for a link's packet
  sync::Micros linkSentAt_ = -sync::kSecond;  // local time
};

}  // namespace tandem::client
