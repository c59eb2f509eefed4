#pragma once

// StateUpdates from one end of a connection to the other in few bytes: parts are encoded as differences to a
// datagram that the receiver has acknowledged. Site to server and server to each site are streams of their
// own, each with its own losses; the server decodes and encodes in between.
//
// 1. Every datagram names its baseline and can be decoded by a receiver that has it. A receiver that lacks it
//    drops the datagram and counts it, so no difference is applied to another baseline.
// 2. Baselines: at most every kKeepInterval the sender marks a datagram to be kept. The receiver keeps it and
//    acknowledges it; the sender encodes against the newest acknowledged one that it still has. Both keep the
//    newest kKept marked datagrams, so the receiver has every baseline that the sender may choose.
// 3. Without an acknowledged baseline (at the start, after an outage of a second) parts are sent whole, so
//    the next datagram gives a receiver a usable state.
// 4. Each datagram against a baseline carries a checksum of the decoded states.
// 5. Both ends keep integer codes, not floating-point numbers, and predict from them: no error accumulates.
//
// The sender is StateSender (state_sender.h), the receiver StateReceiver (state_receiver.h). Neither
// allocates once its buffers have grown; each is used by one thread.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "sync/wire/part_delta.h"

namespace tandem::sync {

inline constexpr Micros kKeepInterval = 40 * kMillisecond;  // by the update's own times
inline constexpr std::size_t kKept = 24;                    // a stream: about a second
inline constexpr Micros kAckInterval = 20 * kMillisecond;   // at least, between two acknowledgements
inline constexpr Micros kCrowdAckInterval = 80 * kMillisecond;  // the same, of the updates of many sites
inline constexpr std::size_t kManyOrigins = 16;                 // more are many

/// The parts of a datagram that both ends keep as a baseline.
struct KeptUpdate {
  std::uint32_t sequence = 0;
  Micros time = 0;
  bool acknowledged = false;  // at the sender
  std::vector<PartBaseline> parts;
};

inline constexpr int kDistanceBits = 16, kCheckBits = 16;

/// A checksum of the states that the receiver must decode: every number enters it, in the order of the wire
/// (sync/WIRE.md).
class StateChecksum {
 public:
  void add(const PartCode& code) {
    for (const std::uint64_t x :
         {std::uint64_t{code.part}, std::uint64_t{code.epoch}, std::uint64_t{code.sequence},
          static_cast<std::uint64_t>(code.pose.largest)})
      mix(x);
    for (const Code3* three :
         {&code.pose.position, &code.pose.three, &code.twist.linear, &code.twist.angular})
      for (const std::int64_t x : *three) mix(static_cast<std::uint64_t>(x));
  }
  std::uint64_t value() const { return state_ >> (64 - kCheckBits); }

 private:
  void mix(std::uint64_t x) { state_ = (state_ ^ x) * 0x9e3779b97f4a7c15u; }
  std::uint64_t state_ = 1;
};

/// The stream of this origin, or null.
template <typename Streams>
auto* findStream(Streams& streams, SiteId origin) {
  const auto at = std::find_if(streams.begin(), streams.end(),
                               [&](const auto& stream) { return stream.origin == origin; });
  return at == streams.end() ? nullptr : &*at;
}

/// Whether sequence `a` is newer than `b`, over a wrap too.
inline bool isNewer(std::uint32_t a, std::uint32_t b) { return static_cast<std::int32_t>(a - b) > 0; }

}  // namespace tandem::sync
