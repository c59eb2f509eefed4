#pragma once

// What a connection has counted and measured, for reports and for display.

#include <cstdint>

#include "sync/transport/transport.h"
#include "sync/wire/traffic.h"

namespace tandem::client {

struct ConnectionStatistics {
  double roundTrip_ms = 0.0;  // 0: no ping of this connection was answered yet
  double lossUp = 0.0, lossDown = 0.0, playOut_ms = 0.0;
  std::uint64_t sentUpdates = 0, receivedUpdates = 0, droppedStates = 0, malformed = 0;
  // Updates encoded against a baseline that this end does not have, or with a checksum that does not match.
  std::uint64_t droppedBaselines = 0;
  std::uint64_t reconnects = 0;
  sync::TransportCounters transport;  // of the present connection
  sync::Traffic sent, received;       // of all connections
};

}  // namespace tandem::client
