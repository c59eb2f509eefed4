#pragma once

// What a site reports of itself, for the metrics; nothing depends on it.

#include <cstdint>

#include "sync/wire/report_messages.h"

namespace tandem::server {

struct SiteFigures {
  sync::SiteReport latest;
  std::uint64_t reports = 0, ticks = 0, missed = 0, forceLimited = 0;  // of this connection

  void add(const sync::SiteReport& report) {
    latest = report;
    ++reports;
    ticks += report.ticks;
    missed += report.missed;
    forceLimited += report.forceLimited;
  }
};

}  // namespace tandem::server
