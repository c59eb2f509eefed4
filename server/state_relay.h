#pragma once

// State datagrams: checked, filtered by ownership, and relayed in the step in which they came.
//
// 1. No datagram closes a connection: what is malformed, early, too much or of another owner is dropped and
//    counted.
// 2. Nothing here allocates once its buffers have grown.
// 3. The messages of one step to a site leave at the end of the step, in as few datagrams as they fit into.

#include <span>
#include <vector>

#include "server/part_service.h"
#include "server/peers.h"
#include "server/publisher.h"
#include "server/session_context.h"
#include "sync/transport/transport.h"
#include "sync/wire/wire.h"

namespace tandem::server {

/// State messages a second that one site may send; the protocol's own rates stay under a quarter of it.
inline constexpr double kMaxDatagramRate = 2000.0;

class StateRelay {
 public:
  /// All that is referred to outlives this. `frame` is how poses are quantised on the wire.
  StateRelay(const sync::WireFrame& frame, SessionContext& context, sync::Transport& transport, Peers& peers,
             PartService& parts, Publisher& publisher);

  /// Handles the messages of one datagram.
  void onDatagram(Peer& peer, std::span<const std::byte> datagram);
  /// Sends what this step has left for all sites.
  void flush();
  /// Frees the baselines of a site that is not coming back.
  void forget(SiteId origin);

 private:
  /// False beyond kMaxDatagramRate: the rest of the datagram is dropped.
  bool onMessage(Peer& peer, std::span<const std::byte> bytes);
  void onPing(Peer& peer, const sync::Ping& ping);
  void onLink(Peer& peer, sync::StateMessage& message);
  void onUpdate(Peer& peer, sync::StateMessage& message);
  /// Sends an update to every other ready site.
  void relay(const Peer& from, sync::StateUpdate& update);
  void acknowledge(Peer& peer);
  /// Queues what `encoded_` holds, until the end of the step or until it no longer fits into one datagram.
  void send(Peer& peer);
  /// Sends a datagram to this peer.
  auto datagramsTo(const Peer& peer) {
    return [this, connection = peer.connection](std::span<const std::byte> datagram) {
      transport_.sendState(connection, datagram);
    };
  }
  bool plausible(const sync::StateUpdate& update) const;
  bool withinRate(StateLeg& leg) const;

  sync::WireFrame frame_;
  SessionContext& context_;
  sync::Transport& transport_;
  Peers& peers_;
  PartService& parts_;
  Publisher& publisher_;
  // An update is decoded into storage of its own, so that no other message frees its vector.
  sync::StateMessage incoming_{sync::StateUpdate{}}, incomingShort_{sync::Ping{}};
  std::vector<std::byte> encoded_;
};

}  // namespace tandem::server
