#pragma once

// Who says of whom that its motion is none that a body makes. Nothing follows from it but that people are
// told.

#include "assets/base/ids.h"

namespace tandem::sync {

/// From a site: it does not believe the motion of what `about` owns or links. From the server, to all: that
/// `site` says so, or (`holds` false) that it has not said so for a while.
struct Doubt {
  SiteId site = kNoSite;  // who says it; the server knows, whatever a site says
  SiteId about = kNoSite;
  bool holds = true;
};

}  // namespace tandem::sync
