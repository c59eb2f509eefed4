#pragma once

// The exchange that synchronises the clocks, measures the round trip and renews the leases.

#include <cstdint>

#include "sync/wire/time.h"

namespace tandem::sync {

/// Site to server, a few times a second: clock, round trip, lease renewal.
struct Ping {
  std::uint32_t sequence = 0;
  Micros siteTime = 0;  // local time when sent
};
struct Pong {
  std::uint32_t sequence = 0;
  Micros siteTime = 0;    // copied from the Ping
  Micros serverTime = 0;  // session time when the Pong was sent
  /// State updates that the server has received from this site so far, for its uplink loss.
  std::uint32_t received = 0;
};

}  // namespace tandem::sync
