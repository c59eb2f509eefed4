#pragma once

// Session time minus local time, estimated from pings: the sample with the smallest round trip of the recent ones wins
// (NTP's clock filter, RFC 5905 section 10), and the estimate slews toward it, so that session time never runs
// backwards and never jumps while it is in use.

#include <array>
#include <cstddef>

#include "sync/time.h"

namespace tandem::sync {

class ClockOffset {
 public:
  /// A Pong: local times of sending and receiving, and the server's session time in between.
  void observe(Micros sent, Micros serverTime, Micros received);
  /// Forget everything (a new connection to a restarted server).
  void reset();

  bool known() const { return count_ > 0; }
  /// Session time at a local time; monotonic in its argument between resets.
  Micros sessionTime(Micros local);
  /// Smallest and latest round trip, and half the smallest as the bound of the offset's error.
  Micros bestRoundTrip() const { return bestRoundTrip_; }
  Micros lastRoundTrip() const { return lastRoundTrip_; }

 private:
  static constexpr std::size_t kWindow = 16;
  struct Sample {
    Micros roundTrip = 0, offset = 0;
  };
  std::array<Sample, kWindow> samples_{};
  std::size_t count_ = 0, next_ = 0;
  Micros bestRoundTrip_ = 0, lastRoundTrip_ = 0;
  double target_us_ = 0.0, current_us_ = 0.0;
  Micros lastLocal_ = 0, lastSession_ = 0;
  bool started_ = false;
};

}  // namespace tandem::sync
