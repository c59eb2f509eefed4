#pragma once

// How bytes travel, behind one interface: real sockets (sync/transport/socket_transport.h) or an in-process
// network on virtual time (sync/transport/virtual_network.h). A site has one connection, number 0; the server
// has one a site.
//
// One thread uses a transport. Nothing here blocks.

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

namespace tandem::sync {

using ConnectionId = std::uint32_t;

struct TransportEvent {
  enum class Kind : std::uint8_t { connected, control, state, closed };
  Kind kind = Kind::closed;
  ConnectionId connection = 0;
  std::span<const std::byte> bytes;  // a whole message; valid until the next poll()
  std::string reason;                // closed: why, in one line; empty when this side closed it
};

/// Counts since the start, for tables and tests.
struct TransportCounters {
  std::uint64_t controlBytesIn = 0, controlBytesOut = 0;
  std::uint64_t stateBytesIn = 0, stateBytesOut = 0;
  std::uint64_t statePacketsIn = 0, statePacketsOut = 0;
  std::uint64_t droppedUnknown = 0;   // datagrams of no known connection
  std::uint64_t droppedForged = 0;    // authentication failed
  std::uint64_t droppedReplayed = 0;  // counter already seen or too old
  std::uint64_t droppedOversized = 0;
  std::uint64_t droppedFlood = 0;      // more datagrams than a server opens of one connection
  std::uint64_t droppedFull = 0;       // a send or receive queue was full
  std::uint64_t failedHandshakes = 0;  // TCP connections that never became a connection here
};

class Transport {
 public:
  virtual ~Transport() = default;
  /// The next event, if there is one.
  virtual bool poll(TransportEvent& event) = 0;
  /// Queues a control message (at most kMaxControlBytes); a peer that does not read is closed when its queue
  /// is full.
  virtual void sendControl(ConnectionId connection, std::span<const std::byte> bytes) = 0;
  /// Sends a datagram (at most kMaxStateBytes), or drops it.
  virtual void sendState(ConnectionId connection, std::span<const std::byte> bytes) = 0;
  /// Gives the network what sendState() has collected, if it collects datagrams: at the end of a step.
  virtual void flush() {}
  /// Bytes of control messages queued and not yet given to the network: for pacing a scene transfer.
  virtual std::size_t controlBacklog(ConnectionId connection) const = 0;
  /// Leaves what this connection sends unread until it is released, datagrams excepted, so that the network
  /// slows that peer alone. Its `closed` event still comes; what is held then is dropped.
  virtual void hold(ConnectionId connection, bool held) = 0;
  /// Says that the peer has proven who it is. Until then its connection may be dropped for other strangers.
  virtual void trust(ConnectionId) {}
  /// Sends what is queued, then closes. No further events of this connection but `closed`.
  virtual void close(ConnectionId connection) = 0;
  virtual const TransportCounters& counters() const = 0;
  /// Where a connection comes from, for people; empty if that is not known.
  virtual std::string addressOf(ConnectionId) const { return {}; }
};

}  // namespace tandem::sync
