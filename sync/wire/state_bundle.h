#pragma once

// State messages that leave one end of a connection at the same time, in one datagram: each datagram costs 32
// bytes of seal and 28 of IP and UDP headers beside its messages.
//
// 1. The messages keep their order; a single message is a datagram without any head.
// 2. No allocation once the buffer has grown.

#include <cstddef>
#include <span>
#include <vector>

namespace tandem::sync {

class StateBundle {
 public:
  /// False if this message does not fit beside those in the bundle, which must be sent first. An empty bundle
  /// takes any message.
  bool add(std::span<const std::byte> message);
  /// Adds a message; where it does not fit, `send` is first given the datagram of those before it.
  template <typename Send>
  void add(std::span<const std::byte> message, const Send& send) {
    if (add(message)) return;
    flush(send);
    add(message);
  }
  template <typename Send>
  void flush(const Send& send) {
    if (!bytes_.empty()) send(bytes());
    clear();
  }
  /// The datagram, to be sent and then cleared. Empty without messages.
  std::span<const std::byte> bytes() const { return bytes_; }
  void clear() { bytes_.clear(), last_ = 0; }

 private:
  std::vector<std::byte> bytes_;
  std::size_t last_ = 0;  // where the last message begins
};

/// Splits the first message off a datagram. Bytes that are no bundle count as one message, which decoding may
/// refuse.
std::span<const std::byte> popMessage(std::span<const std::byte>& datagram);

}  // namespace tandem::sync
