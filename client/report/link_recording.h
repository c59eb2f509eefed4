#pragma once

// The calls of one end of a link in a run, recorded so that they can be replayed and timed.

#include <memory>
#include <vector>

#include "haptics/link_bench/link_end.h"

namespace tandem::client::report {

struct LinkRecording {
  struct Tick {
    double now = 0.0;
    Pose before, after;
    Twist twistBefore, twistAfter;
    std::size_t received = 0;         // packets received until then
    bool sends = false, off = false;  // off: nothing couples the replicas at this delay
  };
  std::vector<haptics::LinkPacket> received, sent;
  std::vector<Tick> ticks;
  /// 0..1 of the ticks.
  double offShare() const;
};

/// A maker that makes ends by `make` and records the first of them.
bench::LinkEndMaker recordingFirst(bench::LinkEndMaker make, std::shared_ptr<LinkRecording> recording);

/// Calls a fresh end as the recorded one was called.
void replay(const LinkRecording& recording, bench::LinkEnd& end);

}  // namespace tandem::client::report
