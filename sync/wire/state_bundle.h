#pragma once

// State messages that leave one end of a connection at the same time, in one datagram: each datagram costs 32 bytes of seal
// and 28 of IP and UDP beside what it says.
//
// 1. In the order in which they were said; one by itself is a datagram as it is.
// 2. No allocation once the buffer has grown.

#include <cstddef>
#include <span>
#include <vector>

namespace tandem::sync {

class StateBundle {
 public:
  /// False if this message does not fit beside those that are there: they are to be sent first. By itself it always fits.
  bool add(std::span<const std::byte> message);
  /// The same; those that are there are sent first where it does not fit. `send` is given a datagram.
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

/// The first message of a datagram, which is left with the others. What is no bundle is one message, sound or not.
std::span<const std::byte> takeMessage(std::span<const std::byte>& datagram);

}  // namespace tandem::sync
