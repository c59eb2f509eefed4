#pragma once

// State and control messages of one direction, counted by what they are for. Bytes are those of the messages:
// on sockets a datagram of several has 3 more for each but the last, sealing adds 32 to each datagram (the
// transport counts them), and a frame 5 and TLS some 22 to each control message.

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
  Flow unknown;  // of a kind that does not exist

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
