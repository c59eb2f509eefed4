#pragma once

// What a site tells the server about itself, for the server's metrics. Nothing depends on it.

#include <cstdint>

namespace tandem::sync {

/// Every kReportPeriod; figures are of the time since the last report, times in microseconds. A site without
/// a hand reports no ticks.
struct SiteReport {
  std::uint32_t ticks = 0;                            // of the haptic loop
  std::uint32_t missed = 0;                           // those that began late
  std::uint32_t forceLimited = 0;                     // those that asked the device for more than it can give
  std::uint32_t tick50 = 0, tick99 = 0, tickMax = 0;  // time of computation: median, 99th percentile, most
  std::uint32_t roundTrip = 0;                        // of a ping, smoothed; 0: not known
};

}  // namespace tandem::sync
