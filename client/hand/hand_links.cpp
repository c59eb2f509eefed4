#include "client/hand/hand_links.h"

namespace tandem::client {

void HandLinks::forget(PartId part, haptics::TickState& state) {
  state.cancelLinkOrders(part);
  simulators_[part] = 1;
}

void HandLinks::receive(Exchange& exchange, haptics::TickState& state) {
  haptics::AddressedPacket packet;
  while (exchange.linksIn.pop(packet)) state.receive(packet);
}

void HandLinks::update(const haptics::TickOutput& tick, haptics::TickState& state, Exchange& exchange) {
  state.beginOrderedLinks();
  for (int i = 0; i < tick.ownedCount; ++i) {
    const haptics::OwnedPart& part = tick.owned[static_cast<std::size_t>(i)];
    if (part.links.count > 0) state.setSimulators(part.part, simulators_[part.part]);
  }
  const std::size_t count = state.drainPackets(packets_);
  for (std::size_t i = 0; i < count; ++i) static_cast<void>(exchange.linksOut.push(packets_[i]));
  const std::size_t doubted = state.drainDoubts(doubts_);
  for (std::size_t i = 0; i < doubted; ++i) static_cast<void>(exchange.doubts.push(doubts_[i].peer));
}

}  // namespace tandem::client
