#include "client/session/site_reports.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "assets/base/assert.h"

namespace tandem::client {

using namespace sync;

namespace {

/// What was counted since `before`; a loop that began anew counts from zero.
std::uint32_t grown(std::uint64_t before, std::uint64_t now) {
  const std::uint64_t growth = now >= before ? now - before : now;
  return static_cast<std::uint32_t>(
      std::min<std::uint64_t>(growth, std::numeric_limits<std::uint32_t>::max()));
}

std::uint32_t inMicros(double time_us) {
  constexpr double kMost = static_cast<double>(kMaxReportedTime);
  return std::isfinite(time_us) ? static_cast<std::uint32_t>(std::clamp(time_us, 0.0, kMost)) : 0;
}

}  // namespace

void SiteReports::reset(Micros now) {
  next_ = now + kReportPeriod;
  if (source_) reported_ = source_();
}

SiteReport SiteReports::next(Micros now, double roundTrip_ms) {
  ASSERT(due(now));
  next_ = now + kReportPeriod;
  const LoopTotals totals = source_();
  SiteReport report;
  report.ticks = grown(reported_.ticks, totals.ticks);
  report.missed = grown(reported_.missed, totals.missed);
  report.forceLimited = std::min(report.ticks, grown(reported_.forceLimited, totals.forceLimited));
  const haptics::DurationCounts compute = totals.compute.since(reported_.compute);
  report.tickMax = inMicros(1e-3 * compute.quantile_ns(1.0));
  report.tick99 = inMicros(1e-3 * compute.quantile_ns(0.99));
  report.tick50 = inMicros(1e-3 * compute.quantile_ns(0.5));
  report.roundTrip = inMicros(1000.0 * roundTrip_ms);
  reported_ = totals;
  return report;
}

}  // namespace tandem::client
