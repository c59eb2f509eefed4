#pragma once

// Accepts TCP connections and keeps them as bare sockets until it is the turn of their TLS handshakes: who
// sends nothing, or no TLS, costs a file descriptor for a while and no more. Internal to the transport.
//
// 1. No state of TLS is made here, and what a client has sent stays in the kernel.
// 2. Work is bounded in each call, so that a flood of connections delays no state.
// 3. The number of sockets is bounded by the options and by what the process may open.

#include <sys/socket.h>

#include <cstdint>
#include <functional>
#include <map>
#include <optional>

#include "sync/transport/handshake_queue.h"
#include "sync/transport/knock.h"
#include "sync/transport/socket_transport.h"

namespace tandem::sync {

/// The network that an address belongs to.
Network networkOf(const sockaddr_storage& address);

class FrontDoor {
 public:
  explicit FrontDoor(const ListenOptions& options);
  ~FrontDoor();
  FrontDoor(const FrontDoor&) = delete;
  FrontDoor& operator=(const FrontDoor&) = delete;

  /// Begins to accept from a listening socket that does not block; it must outlive the door, or close().
  [[nodiscard]] bool open(int listener);
  /// Accepts nobody any more and drops who waits.
  void close();
  /// A descriptor that is readable whenever work() has something to do.
  int descriptor() const { return epoll_; }

  /// Accepts, and reads first bytes, as far as both are there; a bounded number of them.
  void work(Micros now);
  /// Drops who has been silent or has waited for too long.
  void expire(Micros now);

  /// A connection whose TLS handshake may begin; its socket is the caller's.
  struct Guest {
    VisitorId id = 0;
    int socket = -1;
    Network network = 0;
    bool known = false;  // it has shown a genuine knock
    Micros since = 0;    // when it was accepted
  };
  std::optional<Guest> next(Micros now, bool idle);
  /// A guest that was no known one has proven genuine; it was given at that time.
  void takeBack(Network network, Micros at) { queue_.takeBack(network, at); }
  /// When next() may give a guest.
  Micros nextAt(Micros now) { return queue_.nextAt(now); }

  /// Connections dropped here since the last call.
  std::uint64_t drainDropped();

 private:
  struct Visitor {
    int socket = -1;
    Network network = 0;
    Micros since = 0;
    bool ready = false;
  };
  void acceptSome(Micros now);
  void accepted(int socket, const sockaddr_storage& address, Micros now);
  void readFirst(VisitorId id, Micros now);
  void drop(VisitorId id);
  void watchListener(bool watched);

  std::size_t maxVisitors_;
  Micros firstBytesTimeout_, handshakeTimeout_;
  std::function<bool(const Knock&)> knows_;
  HandshakeQueue queue_;
  std::map<VisitorId, Visitor> visitors_;  // oldest first
  int epoll_ = -1, listener_ = -1;
  Micros acceptAt_ = 0;  // if not 0, nobody is accepted before then
  VisitorId nextId_ = 1;
  std::uint64_t dropped_ = 0;
};

}  // namespace tandem::sync
