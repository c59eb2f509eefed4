#pragma once

// Session time minus local time, estimated from pings. Of the recent samples the one with the least error
// bound is used (NTP's clock filter, RFC 5905 section 10: half the round trip, plus the drift of the clocks
// since the sample). The estimate slews toward it, so that session time never runs backwards and never jumps
// while it is in use. It slews faster the further it is off, because a clock that ran wrong for seconds would
// otherwise be useless for minutes.
//
// After the slewing, |estimated - true session time| <= roundTrip / 2 + drift * age of that sample, because
// the shares of ping and pong in the round trip are unknown.

#include <array>
#include <cstddef>

#include "sync/wire/time.h"

namespace tandem::sync {

class ClockOffset {
 public:
  /// A Pong: local times of sending and receiving, and the server's session time in between.
  void observe(Micros sent, Micros serverTime, Micros received);
  /// Forgets all samples, for a new connection: the server may have been restarted.
  void reset();

  bool known() const { return count_ > 0; }
  /// Session time at a local time; monotonic in its argument between resets. Before the first pong: the local
  /// time.
  Micros sessionTime(Micros local);
  /// Smallest of the recent round trips, and the latest one.
  Micros bestRoundTrip() const { return bestRoundTrip_; }
  Micros lastRoundTrip() const { return lastRoundTrip_; }

  /// Session time runs at 1 -+ this against local time, and at 1 -+ error / kCatchUp where that is more:
  /// errors above 50 ms fall by a factor of e every kCatchUp.
  static constexpr double kSlew = 0.02;
  static constexpr Micros kCatchUp = 2500 * kMillisecond;
  static constexpr double kFastestSlew = 0.5;
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
