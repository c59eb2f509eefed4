#include "client/hand/hand_ties.h"

#include <algorithm>

namespace tandem::client {

template <typename Which>
void HandTies::dropOrders(const Which& which) {
  const auto end = orders_.begin() + static_cast<std::ptrdiff_t>(orderCount_);
  orderCount_ = static_cast<std::size_t>(std::remove_if(orders_.begin(), end, which) - orders_.begin());
}

void HandTies::order(const haptics::PartTie& tie) {
  dropOrders([&](const haptics::PartTie& order) { return order.part == tie.part && order.peer == tie.peer; });
  if (orderCount_ < orders_.size()) orders_[orderCount_++] = tie;
}

void HandTies::end(PartId part, SiteId peer, haptics::TickState& state) {
  dropOrders([&](const haptics::PartTie& order) { return order.part == part && order.peer == peer; });
  state.untie(part, peer);
}

void HandTies::forget(PartId part) {
  dropOrders([&](const haptics::PartTie& order) { return order.part == part; });
  simulators_[part] = 1;
}

void HandTies::takePackets(Exchange& exchange, haptics::TickState& state) {
  haptics::TiedPacket packet;
  while (exchange.linksIn.pop(packet)) state.receive(packet.part, packet.peer, packet.packet);
}

void HandTies::carryOut(const haptics::TickOutput& tick, haptics::TickState& state, Exchange& exchange) {
  dropOrders([&](const haptics::PartTie& order) { return carryOut(order, tick, state); });
  for (int i = 0; i < tick.ownedCount; ++i) {
    const haptics::OwnedPart& part = tick.owned[static_cast<std::size_t>(i)];
    if (part.tie.links > 0) state.setSimulators(part.part, simulators_[part.part]);
  }
  const std::size_t count = state.takePackets(packets_);
  for (std::size_t i = 0; i < count; ++i) static_cast<void>(exchange.linksOut.push(packets_[i]));
}

/// Whether there is nothing left to do.
bool HandTies::carryOut(const haptics::PartTie& tie, const haptics::TickOutput& tick,
                        haptics::TickState& state) const {
  if (tick.simulated(tie.part) == nullptr) return false;
  state.tie(tie);  // if there is no room, the peer is alone with its replica
  return true;
}

}  // namespace tandem::client
