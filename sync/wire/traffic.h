#pragma once

// State and control messages of one direction, counted by purpose. Only the bytes of the messages count.
// Sockets add 3 bytes for each message of a datagram but the last and 32 of seal to each datagram, which the
// transport counts, and to each control message 5 of frame and some 22 of TLS.

#include <cstddef>
#include <cstdint>
#include <span>

namespace tandem::sync {

struct Flow {
  std::uint64_t packets = 0, bytes = 0;
};

struct Traffic {
  Flow parts;     // updates with parts
  Flow presence;  // updates without parts, and the bytes of presence in those with parts
  Flow links, pings, acks;
  Flow control;
  Flow unknown;  // of an unknown kind

  /// Counts a message by its first bytes, whether or not it decodes.
  void countState(std::span<const std::byte> datagram);
  void countControl(std::size_t bytes);
  void add(const Traffic& other);
};

/// Each cause by its name, for reports.
inline constexpr struct {
  const char* name;
  Flow Traffic::*flow;
} kTrafficCauses[] = {{"parts", &Traffic::parts},    {"presence", &Traffic::presence},
                      {"links", &Traffic::links},    {"pings", &Traffic::pings},
                      {"acks", &Traffic::acks},      {"control", &Traffic::control},
                      {"unknown", &Traffic::unknown}};

}  // namespace tandem::sync
