#pragma once

// Events from the network to the hand, through the exchange's ring. States may be dropped where the ring is
// full, since newer ones follow; everything else waits until there is room, in order.
//
// Network thread.

#include <cstdint>
#include <vector>

#include "client/session/exchange.h"

namespace tandem::client {

class HandEvents {
 public:
  /// The exchange must outlive this.
  explicit HandEvents(Exchange& exchange) : exchange_(exchange) {}

  void push(const NetworkEvent& event);
  /// Moves waiting events into the ring as far as there is room.
  void flush();
  /// States that were dropped because the ring was full.
  std::uint64_t droppedStates() const { return droppedStates_; }

 private:
  Exchange& exchange_;
  std::vector<NetworkEvent> waiting_;
  std::uint64_t droppedStates_ = 0;
};

}  // namespace tandem::client
