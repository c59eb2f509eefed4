#pragma once

#include <cmath>

#include "sync/wire/time.h"

namespace tandem::client {

/// A monotonic clock that started at another time than virtual time did, and runs at another rate.
class DriftingClock {
 public:
  explicit DriftingClock(sync::Micros offset = 0) : base_(offset) {}

  /// What the clock shows at virtual time `now`, which never goes back.
  sync::Micros at(sync::Micros now) const {
    const sync::Micros elapsed = now - since_;
    if (ppm_ == 0.0) return base_ + elapsed;
    return base_ + elapsed +
           static_cast<sync::Micros>(std::llround(static_cast<double>(elapsed) * ppm_ * 1e-6));
  }
  /// From now on the clock runs this much fast.
  void setDrift(double ppm, sync::Micros now) {
    base_ = at(now);
    since_ = now;
    ppm_ = ppm;
  }
  double drift() const { return ppm_; }

 private:
  sync::Micros base_, since_ = 0;
  double ppm_ = 0.0;
};

}  // namespace tandem::client
