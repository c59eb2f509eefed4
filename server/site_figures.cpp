#include "server/site_figures.h"

#include "assets/base/assert.h"

namespace tandem::server {

bool SiteFigures::possible(const sync::SiteReport& report, sync::Micros now) const {
  ASSERT(now >= since);
  const sync::Micros time = now - since + kSlack;
  const auto most = static_cast<std::uint64_t>(kMostTicks * sync::toSeconds(time));
  return reports < static_cast<std::uint64_t>(time / kLeastPeriod) && ticks + report.ticks <= most &&
         missed + report.missed <= most && report.forceLimited <= report.ticks &&
         report.tick50 <= report.tick99 && report.tick99 <= report.tickMax &&
         report.tickMax <= sync::kMaxReportedTime && report.roundTrip <= sync::kMaxReportedTime;
}

bool SiteFigures::add(const sync::SiteReport& report, sync::Micros now) {
  if (!possible(report, now)) {
    ++refused;
    return false;
  }
  latest = report;
  ++reports;
  ticks += report.ticks;
  missed += report.missed;
  forceLimited += report.forceLimited;
  return true;
}

}  // namespace tandem::server
