#pragma once

// The numbers of a coordination link as they travel: sums and clocks whole at both ends, by their low bits on
// the wire, and the pose in every eighth datagram only.
//
// 1. Datagrams may be lost, doubled and reordered. What is made whole is what lies nearest to the newest one
//    known.
// 2. Energy is rounded down: nobody receives more than was sent.
// 3. No allocation.

#include <array>
#include <cstdint>
#include <optional>

#include "sync/wire/messages.h"

namespace tandem::sync {

/// One end of a link at one instant.
struct LinkState {
  std::uint32_t epoch = 0, sequence = 0;  // the sequence grows by one a datagram, from 1 in each epoch
  Micros time = 0;                        // of the session
  std::array<double, 6> wave{};           // sqrt(W) s: integral of the waves sent; three along, three about
  double energy = 0.0;                    // J, announced since the epoch began
  double fade = 0.0;                      // 0..1
  bool on = false, asks = false;
  std::uint8_t regime = 0;  // 0 stiff, 1 soft, 2 apart
  Pose worldFromDrawn;
  Twist twist;
};

/// For the wire. A pose that is no pose is left out.
LinkUpdate toWire(const LinkState& state, SiteId peer, PartId part);

/// The whole session time of a datagram that came at `now` (session time); nothing if it is later than clocks
/// can differ: the datagram was made before its sender's clock was set.
std::optional<Micros> sessionTimeOf(const LinkUpdate& update, Micros now);

/// Of one peer and one part.
class LinkReceiver {
 public:
  /// The whole of a datagram that came at `now` (session time); nothing if it is of an earlier epoch, lies in
  /// the future, or no pose is known yet. A larger epoch begins anew.
  std::optional<LinkState> receive(const LinkUpdate& update, Micros now);
  /// The same where the datagram's own time is known already, from sessionTimeOf().
  std::optional<LinkState> receiveAt(const LinkUpdate& update, Micros time);
  void forget() { begun_ = false; }

 private:
  bool begun_ = false, posed_ = false;
  LinkState newest_, withPose_;
};

}  // namespace tandem::sync
