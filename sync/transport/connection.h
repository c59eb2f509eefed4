#pragma once

// One connection over sockets, from the TCP connect on: its TLS stream, its path for datagrams, and how far
// it has got. Internal to the transport.

#include <cstddef>
#include <memory>
#include <span>
#include <string>

#include "sync/transport/crowd.h"
#include "sync/transport/state_channel.h"
#include "sync/transport/tls_stream.h"
#include "sync/transport/transport.h"
#include "sync/transport/udp_socket.h"
#include "sync/wire/time.h"

namespace tandem::sync {

class SocketCore;

class Connection : public TlsStream::Listener {
 public:
  explicit Connection(SocketCore& core) : core_(&core) {}

  void onHandshake() override;
  void onFrame(FrameType type, std::span<const std::byte> bytes) override;
  void onClosed(const std::string& reason) override;

  std::shared_ptr<TlsStream> stream;
  std::unique_ptr<StateChannel> channel;  // once the algorithm is agreed
  ConnectionId id = 0;
  std::string address;          // of the TCP connection's other end, HOST:PORT
  UdpAddress peer;              // server: where the newest authentic datagram came from
  std::string farewell;         // the reason that the peer sent before it closed
  std::string refusal;          // the reason that this side sent before it closed
  std::size_t undelivered = 0;  // bytes of events not yet polled
  double states = 0.0;          // server: messages of state that may be opened at once
  Micros statesAt = 0;          // when that was so; at first long ago
  Micros strangeUntil = 0;      // server: its datagrams are treated as those of strangers
  Micros deadline = 0;          // for the handshake, or for the end of close()
  VisitorId visitor = 0;        // server: by which its place among strangers is known
  bool trusted = false;         // server: trust() was called
  bool resting = false;         // server: not read until the next housekeeping, for it sends too much
  bool announced = false;       // `connected` is in the queue or was polled
  bool closing = false;         // by this side

 private:
  SocketCore* core_;
};

}  // namespace tandem::sync
