#pragma once

// The numbers of a coordination link: integrals and clocks travel by their low bits and are completed at the
// receiver; the pose travels in every eighth datagram only.
//
// 1. Datagrams may be lost, doubled and reordered. Low bits are completed to the number nearest to the newest
//    known.
// 2. Energy is rounded down, so that nobody receives more than was sent.
// 3. No allocation.

#include <array>
#include <cstdint>
#include <optional>

#include "sync/wire/link_update.h"
#include "sync/wire/time.h"

namespace tandem::sync {

/// The state of one end of a link at one instant.
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

/// Encodes a state for the wire. A pose that is not valid is left out.
LinkUpdate toWire(const LinkState& state, SiteId peer, PartId part);

/// The session time at which a datagram that arrived at `now` (session time) was made. Nothing if it lies
/// further ahead than synchronised clocks can differ: the sender's clock was not yet synchronised.
std::optional<Micros> sessionTimeOf(const LinkUpdate& update, Micros now);

/// Completes the datagrams of one peer about one part.
class LinkReceiver {
 public:
  /// The completed state of a datagram that arrived at `now` (session time). Nothing if the datagram is of an
  /// earlier epoch or lies in the future, or if no pose is known yet. A larger epoch resets the receiver.
  std::optional<LinkState> receive(const LinkUpdate& update, Micros now);
  /// The same where the datagram's own session time is already known, from sessionTimeOf().
  std::optional<LinkState> receiveAt(const LinkUpdate& update, Micros time);
  void forget() { begun_ = false; }

 private:
  bool begun_ = false, posed_ = false;
  LinkState newest_, withPose_;
};

}  // namespace tandem::sync
