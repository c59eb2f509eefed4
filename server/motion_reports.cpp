#include "server/motion_reports.h"

#include <string>

namespace tandem::server {

void MotionReports::onReport(const Peer& peer, const sync::MotionReport& report) {
  const sync::Micros now = context_.now();
  const auto next = next_.find(peer.site);
  const bool early = now < nextOfAll_ || (next != next_.end() && now < next->second);
  const bool owns = report.part < parts_.count() && report.site != kNoSite &&
                    parts_.table().part(report.part).owner == report.site;
  if (early || !owns || report.site == peer.site) {
    ++context_.counts.droppedReports;
    return;
  }
  std::erase_if(next_, [now](const auto& entry) { return entry.second <= now; });
  next_[peer.site] = now + kPerSite;
  nextOfAll_ = now + kOfAll;
  context_.log.note(sites_.nameOf(peer.site) + "'s site says that part " + std::to_string(report.part) +
                    " of " + sites_.nameOf(report.site) + " moves impossibly");
  publisher_.publish(sync::MotionReported{peer.site, report.part, report.site});
}

}  // namespace tandem::server
