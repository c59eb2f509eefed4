#pragma once

// How many messages of one kind a site may send.

#include <algorithm>

#include "assets/base/assert.h"
#include "sync/wire/time.h"

namespace tandem::server {

/// A token bucket (RFC 2697): `rate` messages a second, `burst` at once.
class MessageRate {
 public:
  MessageRate(double rate, double burst) : rate_(rate), burst_(burst), allowance_(burst) {}
  /// False: this message is too much.
  bool spend(sync::Micros now) {
    ASSERT(now >= at_);
    allowance_ = std::min(burst_, allowance_ + rate_ * sync::toSeconds(now - at_));
    at_ = now;
    if (allowance_ < 1.0) return false;
    allowance_ -= 1.0;
    return true;
  }

 private:
  double rate_, burst_, allowance_;
  sync::Micros at_ = 0;
};

}  // namespace tandem::server
