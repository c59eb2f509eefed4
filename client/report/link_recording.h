#pragma once

// What one end of a tie is called with in a run, to be timed and weighed afterwards.

#include <memory>
#include <vector>

#include "haptics/link_bench/tie_end.h"

namespace tandem::client::report {

struct LinkRecording {
  struct Tick {
    double now = 0.0;
    Pose before, after;
    Twist twistBefore, twistAfter;
    std::size_t heard = 0;            // packets until then
    bool sends = false, off = false;  // off: there is no tie at this delay
  };
  std::vector<haptics::LinkPacket> heard, sent;
  std::vector<Tick> ticks;
  /// 0..1 of the ticks.
  double offShare() const;
};

/// Makes ends as `make` does; the first one that is made is recorded.
bench::TieMaker recordingFirst(bench::TieMaker make, std::shared_ptr<LinkRecording> recording);

/// Calls a fresh end as the recorded one was called.
void replay(const LinkRecording& recording, bench::TieEnd& end);

}  // namespace tandem::client::report
