#pragma once

// State datagrams: checked, filtered by ownership, and relayed in the step in which they came.
//
// 1. No datagram closes a connection: what is malformed, early, too much or of another owner is dropped and
//    counted.
// 2. Nothing here allocates once its buffers have grown.
// 3. Who gets what, and when, is FanOut's (server/fan_out.h).

#include <span>
#include <vector>

#include "server/fan_out.h"
#include "server/part_service.h"
#include "server/peers.h"
#include "server/publisher.h"
#include "server/session_context.h"
#include "sync/wire/wire.h"

namespace tandem::server {

/// State messages a second that one site may send, without those of links; the protocol's own rates stay
/// under a quarter of it.
inline constexpr double kMaxDatagramRate = 2000.0;
/// Messages of links a second that one site may send besides: a site in a row of eight owners has 14 links,
/// no site has more than 16, and each sends 250 messages a second.
inline constexpr double kMaxLinkRate = 5000.0;

class StateRelay {
 public:
  /// All that is referred to outlives this. `frame` is how poses are quantised on the wire.
  StateRelay(const sync::WireFrame& frame, SessionContext& context, Peers& peers, PartService& parts,
             Publisher& publisher, FanOut& fanOut);

  /// Handles the messages of one datagram.
  void onDatagram(Peer& peer, std::span<const std::byte> datagram);
  /// Frees the baselines of a site that is not coming back.
  void forget(SiteId origin) { fanOut_.forget(origin); }

 private:
  /// False beyond kMaxDatagramRate or kMaxLinkRate: the rest of the datagram is dropped.
  bool onMessage(Peer& peer, std::span<const std::byte> bytes);
  void noteFlood(Peer& peer);
  void onPing(Peer& peer, const sync::Ping& ping);
  void onLink(Peer& peer, sync::StateMessage& message);
  void onUpdate(Peer& peer, sync::StateMessage& message);
  void acknowledge(Peer& peer);
  bool plausible(const sync::StateUpdate& update) const;
  bool withinRate(StateLeg& leg, bool ofLink) const;

  sync::WireFrame frame_;
  SessionContext& context_;
  Peers& peers_;
  PartService& parts_;
  Publisher& publisher_;
  FanOut& fanOut_;
  // An update is decoded into storage of its own, so that no other message frees its vector.
  sync::StateMessage incoming_{sync::StateUpdate{}}, incomingShort_{sync::Ping{}};
  std::vector<std::byte> encoded_;
};

}  // namespace tandem::server
