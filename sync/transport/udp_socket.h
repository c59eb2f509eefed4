#pragma once

// Datagrams in batches, straight from the system calls: no allocation and no copy per packet. The caller owns
// and watches the socket.

#include <netinet/in.h>

#include <array>
#include <cstddef>
#include <memory>
#include <span>

#include "sync/transport/state_channel.h"

namespace tandem::sync {

/// An IPv4 or IPv6 address with its port, as the kernel has it.
struct UdpAddress {
  sockaddr_in6 storage{};
  socklen_t size = 0;
};

class UdpBatch {
 public:
  static constexpr std::size_t kCapacity = 32;

  UdpBatch();
  ~UdpBatch();

  /// Receives what has arrived on a non-blocking socket; true if there may be more.
  bool receive(int socket);
  bool empty() const { return next_ == count_; }

  struct Datagram {
    std::span<const std::byte> bytes;  // valid until receive()
    const UdpAddress* from = nullptr;
    bool oversized = false;
  };
  /// The next datagram of a batch that is not empty.
  Datagram pop();

 private:
  struct Buffers;
  std::unique_ptr<Buffers> buffers_;
  std::size_t count_ = 0, next_ = 0;
};

/// Datagrams that leave in one system call.
class UdpSendBatch {
 public:
  static constexpr std::size_t kCapacity = 64;

  UdpSendBatch();
  ~UdpSendBatch();

  bool empty() const { return count_ == 0; }
  bool full() const { return count_ == kCapacity; }
  /// Where the next datagram is written: kMaxDatagramBytes. The batch is not full.
  std::byte* next();
  /// Takes the datagram that was written to next().
  void add(const UdpAddress& to, std::size_t bytes);
  /// Sends all without blocking, and is empty afterwards. Returns how many did not fit into the send queue.
  std::size_t send(int socket);

 private:
  struct Buffers;
  std::unique_ptr<Buffers> buffers_;
  std::size_t count_ = 0;
};

/// Sends without blocking; `to` null: to where the socket is connected. False: the send queue was full.
bool sendDatagram(int socket, const UdpAddress* to, std::span<const std::byte> bytes);

/// Makes the kernel's buffers as large as the system allows, so that a burst from many sites is not lost
/// before this thread runs.
void enlargeBuffers(int socket);

}  // namespace tandem::sync
