#pragma once

// Coordination links on the hand's side: packets between the network thread and the links of the tick, and
// how many sites simulate each part. The links themselves, and the orders for links whose part is not
// simulated yet, are the tick's (haptics/link/replica_links.h).
//
// Haptic thread; allocates in the constructor only.

#include <array>
#include <vector>

#include "client/session/exchange.h"
#include "haptics/link/replica_links.h"
#include "haptics/tick.h"

namespace tandem::client {

class HandLinks {
 public:
  explicit HandLinks(std::size_t parts) : simulators_(parts, 1) {}

  /// Cancels the orders of a part that is not simulated here any more.
  void forget(PartId part, haptics::TickState& state);

  /// How many sites simulate a part.
  void setSimulators(PartId part, int simulators) { simulators_[part] = simulators; }
  int simulators(PartId part) const { return simulators_[part]; }

  /// Before a tick: hands the packets of peers to their links.
  void receive(Exchange& exchange, haptics::TickState& state);
  /// After it: begins the ordered links whose part it simulates, sends the packets that are due, and tells
  /// whose packets are not believed. What finds no room in its ring is lost, as on the network.
  void update(const haptics::TickOutput& tick, haptics::TickState& state, Exchange& exchange);

 private:
  std::array<haptics::AddressedPacket, haptics::ReplicaLinks::kMaxLinks> packets_;
  std::array<haptics::LinkId, haptics::ReplicaLinks::kMaxLinks> doubts_;
  std::vector<int> simulators_;  // by part
};

}  // namespace tandem::client
