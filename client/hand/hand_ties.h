#pragma once

// The ties of the parts that this site simulates to other sites' replicas, on the hand's side: orders that wait until the
// tick simulates the part, and packets in and out.
//
// Haptic thread; allocates in the constructor only.

#include <array>
#include <vector>

#include "client/session/exchange.h"
#include "haptics/link/tied_parts.h"
#include "haptics/tick.h"

namespace tandem::client {

class HandTies {
 public:
  explicit HandTies(std::size_t parts) : simulators_(parts, 1) {}

  /// As soon as the part is simulated here; replaces an order for the same peer.
  void order(const haptics::PartTie& tie);
  void end(PartId part, SiteId peer, haptics::TickState& state);
  /// The part is not simulated here any more.
  void forget(PartId part);

  /// How many sites simulate a part.
  void setSimulators(PartId part, int simulators) { simulators_[part] = simulators; }
  int simulators(PartId part) const { return simulators_[part]; }

  /// Before a tick: what peers said.
  void takePackets(Exchange& exchange, haptics::TickState& state);
  /// After it: orders whose part it simulates, and what is due to peers. What finds no room is lost, as on the way.
  void carryOut(const haptics::TickOutput& tick, haptics::TickState& state, Exchange& exchange);

 private:
  bool carryOut(const haptics::PartTie& tie, const haptics::TickOutput& tick,
                haptics::TickState& state) const;
  template <typename Which>
  void dropOrders(const Which& which);

  std::array<haptics::PartTie, haptics::TiedParts::kMaxTies> orders_;
  std::size_t orderCount_ = 0;
  std::array<haptics::TiedPacket, haptics::TiedParts::kMaxTies> packets_;
  std::vector<int> simulators_;  // by part
};

}  // namespace tandem::client
