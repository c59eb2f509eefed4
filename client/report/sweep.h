#pragma once

// Speed against error: every experiment with every setting, in this process. Costs are measured, forces
// compared with exact answers.

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "client/report/experiment.h"
#include "client/report/figures.h"
#include "client/report/link_measurement.h"
#include "client/report/measurement.h"
#include "client/report/part_measurement.h"

namespace tandem::client::report {

struct SweepOptions {
  bool quick = false;          // fewer experiments, shorter paths
  bool thoroughLinks = false;  // across the network: three seeds, and the best gains of others searched for
  std::vector<std::string> only;  // ids of experiments; empty: all (of --quick, if set)
  /// Heap allocations of this thread so far; null where nobody counts them.
  std::uint64_t (*allocations)() = nullptr;
  /// Told before each experiment: how many are done, of how many, and which comes.
  std::function<void(std::size_t, std::size_t, const ExperimentInfo&)> progress;
};

/// One experiment with all its settings.
struct ExperimentResult {
  ExperimentInfo info;
  std::size_t triangles = 0, parts = 0, ticks = 0;
  double peakForce = 0.0;   // N, exact
  double facetError = 0.0;  // N: what the facets alone may cost, from their depth and tilt; 0 = exact facets
  std::vector<Measurement> settings;
};

/// One experiment with a part in the hand, with all its settings.
struct PartExperimentResult {
  ExperimentInfo info;
  std::size_t triangles = 0, ticks = 0;
  double peakForce = 0.0;   // N, exact, of the judged ticks
  double askedDepth = 0.0;  // m, the most that the project allows itself
  std::vector<PartMeasurement> settings;
};

/// Two sites at one delay, with all settings.
struct LinkExperimentResult {
  ExperimentInfo info;
  double delay = 0.0;  // s, one way
  int seeds = 1;
  std::vector<LinkMeasurement> settings;
};

struct SweepResult {
  bool quick = false;
  std::string machine;
  std::vector<ExperimentResult> experiments;
  std::vector<PartExperimentResult> held;
  std::vector<LinkExperimentResult> links;
  std::vector<Figure> figures;     // empty where single experiments were asked for
  std::vector<std::string> peers;  // that were measured, with versions
};

/// The experiments that the options ask for, in the report's order.
std::vector<ExperimentInfo> chosenExperiments(const SweepOptions& options);

/// Ticks of a path.
int ticksOf(const SweepOptions& options);

/// Runs of one setting: each tick's cost is the least of them.
int runsOf(const SweepOptions& options);

/// Seconds to minutes; everything happens in the calling thread but the building of trees.
SweepResult sweep(const SweepOptions& options);

/// Processor, cores and load, in one line.
std::string machineLine();

}  // namespace tandem::client::report
