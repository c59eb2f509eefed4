#pragma once

// What a site tells the server of itself, for the operator's metrics: its haptic loop and the round trip. It
// costs a control message every kReportPeriod, and the haptic thread nothing.
//
// Network thread.

#include <cstdint>
#include <functional>

#include "haptics/base/duration_histogram.h"
#include "sync/wire/report_messages.h"

namespace tandem::client {

/// The haptic loop so far.
struct LoopTotals {
  std::uint64_t ticks = 0, missed = 0, forceLimited = 0;
  haptics::DurationCounts compute;
};

class SiteReports {
 public:
  /// Called in the network thread. A site without one reports nothing.
  using Source = std::function<LoopTotals()>;

  void setSource(Source source) { source_ = std::move(source); }
  /// A new connection at local time `now`: what happened before it is not reported.
  void reset(sync::Micros now);
  bool due(sync::Micros now) const { return source_ && now >= next_; }
  /// Must be due.
  sync::SiteReport next(sync::Micros now, double roundTrip_ms);

 private:
  Source source_;
  LoopTotals reported_;
  sync::Micros next_ = 0;  // local time
};

}  // namespace tandem::client
