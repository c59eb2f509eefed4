#pragma once

// Session time minus local time, estimated from pings: the sample with the smallest round trip of the recent
// ones wins (NTP's clock filter, RFC 5905 section 10; an older sample counts as worse by what the clocks may
// have drifted apart since), and the estimate slews toward it, so that session time never runs backwards and
// never jumps while it is in use.
//
// Once the slewing has caught up, |estimated - true session time| <= bestRoundTrip / 2 + drift * age of that
// sample: the ping and the pong together took the round trip, and nobody knows how it was shared between
// them.

#include <array>
#include <cstddef>

#include "sync/wire/time.h"

namespace tandem::sync {

class ClockOffset {
 public:
  /// A Pong: local times of sending and receiving, and the server's session time in between.
  void observe(Micros sent, Micros serverTime, Micros received);
  /// Forget everything (a new connection to a restarted server).
  void reset();

  bool known() const { return count_ > 0; }
  /// Session time at a local time; monotonic in its argument between resets. Before the first pong: the local
  /// time.
  Micros sessionTime(Micros local);
  /// Smallest of the recent round trips, and the latest one.
  Micros bestRoundTrip() const { return bestRoundTrip_; }
  Micros lastRoundTrip() const { return lastRoundTrip_; }

  static constexpr double kSlew = 0.02;       // session time runs at 1 -+ this against local time
  static constexpr double kDriftPpm = 100.0;  // two quartz clocks

 private:
  static constexpr std::size_t kWindow = 16;
  struct Sample {
    Micros roundTrip = 0, offset = 0, received = 0;
  };
  std::array<Sample, kWindow> samples_{};
  std::size_t count_ = 0, next_ = 0;
  Micros bestRoundTrip_ = 0, lastRoundTrip_ = 0;
  double target_us_ = 0.0, current_us_ = 0.0;
  Micros lastLocal_ = 0, lastSession_ = 0;
  bool started_ = false;
};

}  // namespace tandem::sync
