#pragma once

// What a sweep over experiments and settings is asked for.

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "client/report/experiment.h"
#include "client/report/stroke_sweep.h"

namespace tandem::client::report {

struct SweepOptions {
  bool quick = false;  // fewer experiments, shorter paths
  bool thoroughLinks =
      false;  // across the network: three seeds, and a search of the best gains of the rivals
  std::vector<std::string> only;  // ids of experiments; empty: all (of --quick, if set)
  std::vector<StrokedModel> models;
  int strokes = 0;  // through each model; 0: 20 with `quick`, else 200
  /// Returns the heap allocations of this thread so far; null where they are not counted.
  std::uint64_t (*allocations)() = nullptr;
  /// Called before each experiment: experiments done, number of all, and the next one.
  std::function<void(std::size_t, std::size_t, const ExperimentInfo&)> progress;
};

/// Those of `all` that the options ask for.
std::vector<ExperimentInfo> chosenOf(const std::vector<ExperimentInfo>& all, const SweepOptions& options);

}  // namespace tandem::client::report
