#pragma once

// What a site reports of itself, for the metrics. Nothing of the session depends on it, but whoever reads the
// metrics does: a report that cannot be true is refused whole and counted.

#include <cstdint>

#include "sync/wire/report_messages.h"
#include "sync/wire/time.h"

namespace tandem::server {

/// Of one connection of a site.
struct SiteFigures {
  sync::SiteReport latest;
  std::uint64_t reports = 0, ticks = 0, missed = 0, forceLimited = 0;
  std::uint64_t refused = 0;  // reports
  sync::Micros since = 0;     // session time at which the site became ready

  /// False: the report is refused.
  [[nodiscard]] bool add(const sync::SiteReport& report, sync::Micros now);

  // Totals are bounded by the time in the session, so that reports which a slow network delivers together are
  // taken. `kSlack` is for clocks that differ and for what is under way.
  static constexpr double kMostTicks = 4000.0;  // a second; loops run at 1000
  static constexpr sync::Micros kSlack = 10 * sync::kSecond;
  static constexpr sync::Micros kLeastPeriod = sync::kReportPeriod / 2;  // on average

 private:
  bool possible(const sync::SiteReport& report, sync::Micros now) const;
};

}  // namespace tandem::server
