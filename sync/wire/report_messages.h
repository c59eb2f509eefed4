#pragma once

// What a site tells the server about itself, for the server's metrics. Nothing depends on it.

#include <cstdint>

#include "sync/wire/time.h"

namespace tandem::sync {

inline constexpr Micros kReportPeriod = 5 * kSecond;
inline constexpr Micros kMaxReportedTime = 60 * kSecond;  // a longer time is reported as this

/// Every kReportPeriod, of the time since the last report, or since the site entered. Times in microseconds.
/// A site without a hand reports no ticks.
struct SiteReport {
  std::uint32_t ticks = 0;                            // of the haptic loop
  std::uint32_t missed = 0;                           // those that began late or were left out
  std::uint32_t forceLimited = 0;                     // those that asked the device for more than it can give
  std::uint32_t tick50 = 0, tick99 = 0, tickMax = 0;  // time of computation: median, 99th percentile, most
  std::uint32_t roundTrip = 0;                        // of the newest ping; 0: not known
};

}  // namespace tandem::sync
