#pragma once

// Clashes of an assembly as a window shows them: the question, the progress of the search, and its findings.
// Plain data.

#include <cstddef>
#include <memory>
#include <vector>

#include "client/review/clash_check.h"

namespace tandem::client {

struct ClashQuestion {
  double clearance = 1e-3;  // m, below which parts that do not touch are reported
  bool atRest = false;      // at the file's poses; else at those of the moment of the question
};

struct FoundClash {
  Clash clash;
  bool overlapsAtRest = false;  // a hard clash whose parts overlap at the file's poses too
};

/// The answer to one question.
struct ClashFindings {
  ClashQuestion asked;
  std::vector<FoundClash> found;    // hard clashes that do not overlap at rest first, then as in ClashReport
  std::vector<Pose> worldFromPart;  // where the parts stood, one a part
  std::size_t pairs = 0;            // pairs whose boxes came as near as the clearance
  bool complete = true;             // false: stopped before all pairs were measured
};

struct ClashSearchView {
  bool possible = false;  // a search can be started
  bool running = false;
  std::size_t done = 0, pairs = 0;                // of the running search
  std::shared_ptr<const ClashFindings> findings;  // of the last search; null before one has ended
};

}  // namespace tandem::client
