#pragma once

// The search for a part's way out of its assembly, as a window shows it.

#include <string>
#include <vector>

#include "assets/base/ids.h"
#include "assets/base/pose.h"

namespace tandem::client {

struct WayOutView {
  bool possible = false;  // this window can search
  PartId part = kNoPart;  // whose way is searched for, or was found; none: of nothing
  bool running = false;
  double done = 0.0;              // 0..1, of what it is doing
  std::string words;              // that, or what was found
  bool free = false;              // the part comes out
  std::vector<Pose> path;         // world from part, along the way; of a blocked part as far as it comes
  std::vector<PartId> blockedBy;  // of a part that does not
};

}  // namespace tandem::client
