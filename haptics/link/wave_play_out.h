#pragma once

// Play-out buffer of a coordination link: packets enter in any order, one continuous wave comes out.
//
// 1. The order of arrival, duplicates and packets of another epoch make no difference.
// 2. The sums are interpolated between packets, so a lost packet loses neither displacement nor energy.
// 3. Nothing is extrapolated beyond the newest packet; play() reports that it starved.
// 4. Nothing allocates. Packets that come too late or do not fit are dropped, oldest first.

#include <array>
#include <cstddef>
#include <utility>

#include "assets/base/assert.h"
#include "haptics/base/link_packet.h"

namespace tandem::haptics {

/// The peer at one instant.
struct PlayedWave {
  // True if a packet newer than the instant exists, so that the rest is interpolated; otherwise it is the
  // last known state.
  bool fresh = false;
  // Wave, energy and pose are those at the instant; `fade`, `on` and `twist` are those of the packet before.
  LinkPacket state;
  SixAxes rate;  // sqrt(W): slope of `wave` between the two packets
};

class WavePlayOut {
 public:
  static constexpr double kFastestFade = 8.0;    // 1/s: that of a fade-in of 0.25 s, and a little more
  static constexpr std::size_t kCapacity = 256;  // packets: a quarter of a second at 1 kHz

  /// Clears the buffer; accepts packets of this epoch from now on.
  void restart(std::uint32_t epoch);
  /// Accepts packets of this epoch, and of the previous one until the first packet of this one arrives: both
  /// are one sequence.
  void carryOn(std::uint32_t epoch);
  /// False if the packet was dropped: invalid, of another epoch, a duplicate, or too late.
  bool receive(const LinkPacket& packet);
  /// The state of the peer at `time` (s, session clock). Packets that later times do not need are dropped.
  PlayedWave play(double time);

  /// Whether a packet since the last call was dropped because it contradicts others in time, energy or fade.
  bool drainContradiction() { return std::exchange(contradicted_, false); }

  bool empty() const { return count_ == 0; }
  /// The packet that was made last. The buffer must not be empty.
  const LinkPacket& newest() const {
    ASSERT(count_ > 0);
    return at(count_ - 1);
  }

 private:
  static constexpr double kNothingPlayed = -1e300;

  LinkPacket& at(std::size_t i) { return packets_[(first_ + i) % kCapacity]; }
  const LinkPacket& at(std::size_t i) const { return packets_[(first_ + i) % kCapacity]; }
  void dropFirst();

  std::array<LinkPacket, kCapacity> packets_;  // a ring, by sequence
  std::size_t first_ = 0, count_ = 0;
  std::uint32_t epoch_ = 0, before_ = 0;  // equal unless the previous epoch is accepted too
  bool contradicted_ = false;
  double playedTo_ = kNothingPlayed;  // s, session clock
};

}  // namespace tandem::haptics
