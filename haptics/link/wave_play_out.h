#pragma once

// The play-out buffer of a coordination link: packets in any order in, one continuous wave out.
//
// 1. Order of arrival, duplicates and packets of another epoch change nothing.
// 2. Between two packets the sums are interpolated, so a lost packet loses neither way nor energy.
// 3. Beyond the newest packet nothing is made up: play() says that it ran dry.
// 4. No allocation. What comes too late or does not fit is dropped, oldest first.

#include <array>
#include <cstddef>

#include "haptics/base/link_packet.h"

namespace tandem::haptics {

/// The peer at one instant.
struct PlayedWave {
  bool fresh =
      false;  // there is a packet newer than the instant, so all below is interpolated; else it is the last known
  LinkPacket
      state;     // `wave`, `energy` and pose at the instant, `fade`, `on` and `twist` of the packet before
  SixAxes rate;  // sqrt(W): slope of `wave` between the two packets
};

class WavePlayOut {
 public:
  static constexpr std::size_t kCapacity = 256;  // packets: a quarter of a second at 1 kHz

  /// Forgets everything; takes packets of this epoch from now on.
  void restart(std::uint32_t epoch);
  /// Takes packets of this epoch, and those of the one before until there is one of it: both are one sequence.
  void carryOn(std::uint32_t epoch);
  /// False if the packet was of no use: invalid, of another epoch, known, or too late.
  bool receive(const LinkPacket& packet);
  /// What the peer did at `time` (s, session clock). Packets that are no longer needed for later times are dropped.
  PlayedWave play(double time);

  bool empty() const { return count_ == 0; }
  /// The packet that was made last; not of an empty buffer.
  const LinkPacket& newest() const { return at(count_ - 1); }

 private:
  static constexpr double kNothingPlayed = -1e300;

  LinkPacket& at(std::size_t i) { return packets_[(first_ + i) % kCapacity]; }
  const LinkPacket& at(std::size_t i) const { return packets_[(first_ + i) % kCapacity]; }
  void dropFirst();

  std::array<LinkPacket, kCapacity> packets_;  // a ring, by sequence
  std::size_t first_ = 0, count_ = 0;
  std::uint32_t epoch_ = 0, before_ = 0;  // the same, but while the one before is taken too
  double playedTo_ = kNothingPlayed;      // s, session clock
};

}  // namespace tandem::haptics
