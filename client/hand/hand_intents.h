#pragma once

// What the hand asks of the network thread. Each intent carries the count of lost connections that the hand
// knows: an intent from before the last loss is void.
//
// Haptic thread.

#include "client/session/exchange.h"

namespace tandem::client {

class HandIntents {
 public:
  /// The exchange must outlive this.
  explicit HandIntents(Exchange& exchange) : exchange_(exchange) {}

  /// False if the network thread accepts nothing now.
  bool push(HandIntent intent) {
    intent.lost = lost_;
    return exchange_.intents.push(intent);
  }
  bool grab(PartId part) { return push({HandIntent::Kind::grab, part, 0, {}}); }
  bool leave(PartId part) { return push({HandIntent::Kind::leave, part, 0, {}}); }

  void onConnectionLost() { ++lost_; }

 private:
  Exchange& exchange_;
  std::uint32_t lost_ = 0;
};

}  // namespace tandem::client
