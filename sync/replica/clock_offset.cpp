#include "sync/replica/clock_offset.h"

#include <algorithm>
#include <cmath>

#include "assets/base/assert.h"

namespace tandem::sync {

void ClockOffset::observe(Micros sent, Micros serverTime, Micros received) {
  const Micros roundTrip = received - sent;
  if (roundTrip < 0) return;
  lastRoundTrip_ = roundTrip;
  // RFC 5905 section 8: offset = ((T2 - T1) + (T3 - T4)) / 2 and delay = (T4 - T1) - (T3 - T2). The server
  // answers at once, T2 = T3 = serverTime; T1 = sent, T4 = received.
  samples_[next_] = {roundTrip, serverTime - (sent + roundTrip / 2), received};
  next_ = (next_ + 1) % kWindow;
  count_ = std::min(count_ + 1, kWindow);

  const Sample* best = nullptr;
  double bestBound = 0.0;
  bestRoundTrip_ = roundTrip;
  for (std::size_t i = 0; i < count_; ++i) {
    const Sample& sample = samples_[i];
    const auto age = static_cast<double>(std::max<Micros>(0, received - sample.received));
    const double bound = 0.5 * static_cast<double>(sample.roundTrip) + age * kDriftPpm * 1e-6;
    if (best == nullptr || bound < bestBound) {
      best = &sample;
      bestBound = bound;
    }
    bestRoundTrip_ = std::min(bestRoundTrip_, sample.roundTrip);
  }
  ASSERT(best != nullptr && bestRoundTrip_ >= 0 && bestRoundTrip_ <= roundTrip);
  target_us_ = static_cast<double>(best->offset);
  // Before the first use of session time the estimate may jump: nothing depends on it yet.
  if (!started_) current_us_ = target_us_;
}

void ClockOffset::reset() { *this = ClockOffset{}; }

Micros ClockOffset::sessionTime(Micros local) {
  if (!known()) return local;
  if (!started_) {
    started_ = true;
    lastLocal_ = local;
    lastSession_ = local + static_cast<Micros>(std::llround(current_us_));
  } else if (local <= lastLocal_) {
    return lastSession_ - (lastLocal_ - local);
  } else {
    // Slewing: session time runs at 1 -+ kFastestSlew against local time at most, and so never backwards.
    const double error_us = target_us_ - current_us_;
    const double rate = std::clamp(std::abs(error_us) / static_cast<double>(kCatchUp), kSlew, kFastestSlew);
    const double most = rate * static_cast<double>(local - lastLocal_);
    current_us_ += std::clamp(error_us, -most, most);
    lastLocal_ = local;
    // Rounding may take back a microsecond that was already given out.
    lastSession_ = std::max(lastSession_, local + static_cast<Micros>(std::llround(current_us_)));
  }
  return lastSession_;
}

}  // namespace tandem::sync
