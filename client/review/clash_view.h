#pragma once

// Clashes of an assembly as a window shows them: what was asked, how far the search is, what it found. Plain data.

#include <cstddef>
#include <memory>
#include <vector>

#include "client/review/clash_check.h"

namespace tandem::client {

struct ClashQuestion {
  double clearance = 1e-3;  // m, below which parts that do not touch are told
  bool atRest = false;      // where the file has the parts; else as they stand when it is asked
};

struct FoundClash {
  Clash clash;
  bool overlapsAtRest = false;  // of a hard one: the parts overlap where the file has them too
};

/// The answer to one question.
struct ClashFindings {
  ClashQuestion asked;
  std::vector<FoundClash> found;    // hard ones that are none at rest first, then as in ClashReport
  std::vector<Pose> worldFromPart;  // where the parts stood, one a part
  std::size_t pairs = 0;            // that came as near as the clearance by their boxes
  bool complete = true;             // false: stopped before all pairs were asked
};

struct ClashSearchView {
  bool possible = false;  // somebody here can look for clashes
  bool running = false;
  std::size_t done = 0, pairs = 0;                // of the running search
  std::shared_ptr<const ClashFindings> findings;  // of the last search; null before one has ended
};

}  // namespace tandem::client
