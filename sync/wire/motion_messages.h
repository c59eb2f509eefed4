#pragma once

// What sites tell each other about sites that lie. A report may be a lie itself: nothing follows from it but
// a line for people, which names who said it.

#include "assets/base/ids.h"

namespace tandem::sync {

/// Site to server: the states of this part, published by its owner `site`, are impossible motions
/// (sync/replica/motion_judge.h).
struct MotionReport {
  PartId part = kNoPart;
  SiteId site = kNoSite;
};
/// Server to every site: `reporter` has said so.
struct MotionReported {
  SiteId reporter = kNoSite;
  PartId part = kNoPart;
  SiteId site = kNoSite;
};

}  // namespace tandem::sync
