#pragma once

// The sending side of a site: messages are encoded, counted, and given to the transport of the present
// connection. State messages of one step leave in one datagram.
//
// 1. Messages leave in the order in which they are sent; control messages at once, state messages at flush().
// 2. The transport belongs to the connection, which attaches each new one and detaches the one that is
//    closed.
//
// Network thread.

#include <span>
#include <vector>

#include "sync/transport/transport.h"
#include "sync/wire/state_bundle.h"
#include "sync/wire/traffic.h"
#include "sync/wire/wire.h"

namespace tandem::client {

class MessageSender {
 public:
  MessageSender();

  /// Null detaches.
  void attach(sync::Transport* transport) { transport_ = transport; }

  /// Needs a transport.
  void send(const sync::ControlMessage& message);
  /// Needs a transport.
  void sendState(const sync::StateMessage& message, const sync::WireFrame& frame);
  /// The same for a state message that is encoded already.
  void sendEncoded(std::span<const std::byte> message);
  /// Sends the state messages since the last call.
  void flush();

  /// Of all connections.
  const sync::Traffic& sent() const { return sent_; }

 private:
  sync::Transport* transport_ = nullptr;
  sync::Traffic sent_;
  sync::StateBundle unsent_;
  std::vector<std::byte> bytes_;
};

}  // namespace tandem::client
