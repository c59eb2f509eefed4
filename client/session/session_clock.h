#pragma once

// The time of the present step: local time, and the session time that pings estimate.
//
// Network thread.

#include "sync/replica/clock_offset.h"

namespace tandem::client {

class SessionClock {
 public:
  /// A step begins at local time `now`.
  void advance(sync::Micros now) { now_ = now; }
  /// A new connection: the server may have been restarted, with another session time.
  void reset() { offset_.reset(); }
  /// A Pong that comes in this step answers a Ping of local time `sent`.
  void observe(sync::Micros sent, sync::Micros serverTime) { offset_.observe(sent, serverTime, now_); }

  /// Whether a Pong has arrived on this connection.
  bool known() const { return offset_.known(); }
  /// Local time.
  sync::Micros now() const { return now_; }
  /// Session time at a local time; 0 before the first Pong.
  sync::Micros at(sync::Micros local) { return known() ? offset_.sessionTime(local) : 0; }
  /// Session time of the present step; 0 before the first Pong.
  sync::Micros time() { return at(now_); }
  sync::Micros lastRoundTrip() const { return offset_.lastRoundTrip(); }

 private:
  sync::ClockOffset offset_;
  sync::Micros now_ = 0;
};

}  // namespace tandem::client
