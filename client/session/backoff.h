#pragma once

// When to try to connect again: truncated exponential back-off, without the random part, since a session has
// few sites.

#include <algorithm>

#include "sync/wire/time.h"

namespace tandem::client {

class Backoff {
 public:
  Backoff(sync::Micros first, sync::Micros longest) : first_(first), longest_(longest), delay_(first) {}

  bool due(sync::Micros now) const { return now >= at_; }
  /// The next attempt waits twice as long as this one did, up to the longest delay.
  void failed(sync::Micros now) {
    at_ = now + delay_;
    delay_ = std::min(2 * delay_, longest_);
  }
  /// The delay after the next failure is the first one again.
  void succeeded() { delay_ = first_; }

 private:
  sync::Micros first_, longest_, delay_;
  sync::Micros at_ = 0;
};

}  // namespace tandem::client
