#pragma once

// Passes on what sites say about the motion of other sites' parts.
//
// A report may be a lie, and reports may come in floods, so the server believes none of them. It passes on
// who said it of whom, while the accused owns the part; one in kPerSite from a site, one in kOfAll in all.
// Nobody is parted from for a report.

#include <cstdint>
#include <map>

#include "server/part_service.h"
#include "server/peers.h"
#include "server/publisher.h"
#include "server/session_context.h"
#include "server/sites.h"
#include "sync/wire/motion_messages.h"

namespace tandem::server {

class MotionReports {
 public:
  static constexpr sync::Micros kPerSite = 5 * sync::kSecond;
  static constexpr sync::Micros kOfAll = 200 * sync::kMillisecond;

  /// All that is referred to outlives this.
  MotionReports(SessionContext& context, const Sites& sites, Publisher& publisher, const PartService& parts)
      : context_(context), sites_(sites), publisher_(publisher), parts_(parts) {}

  void onReport(const Peer& peer, const sync::MotionReport& report);

 private:
  SessionContext& context_;
  const Sites& sites_;
  Publisher& publisher_;
  const PartService& parts_;
  std::map<SiteId, sync::Micros> next_;  // session time from which a site may report again
  sync::Micros nextOfAll_ = 0;
};

}  // namespace tandem::server
