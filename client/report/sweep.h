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

/// One experiment with all its settings.
struct ExperimentResult {
  ExperimentInfo info;
  std::size_t triangles = 0, parts = 0, ticks = 0;
  double peakForce = 0.0;   // N, exact
  double facetError = 0.0;  // N: error from the depth and tilt of the facets alone; 0 = exact facets
  std::vector<Measurement> settings;
};

/// One experiment with a part in the hand, with all its settings.
struct PartExperimentResult {
  ExperimentInfo info;
  std::size_t triangles = 0, ticks = 0;
  double peakForce = 0.0;    // N, exact, of the judged ticks
  double targetDepth = 0.0;  // m, the project's target
  std::vector<PartMeasurement> settings;
};

/// One setting over all presses of a family.
struct PressMeasurement {
  PartMeasurement figures;
  int beyond = 0;  // presses that went deeper than is asked
};

/// Irregular parts of one family pressed onto each other, with all settings.
struct PressResult {
  ExperimentInfo info;
  int presses = 0;
  std::size_t leastTriangles = 0, mostTriangles = 0;  // of a pair
  std::size_t ticks = 0;                              // of all presses
  double targetDepth = 0.0;                           // m, the project's target
  std::vector<PressMeasurement> settings;
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
  std::vector<PressResult> presses;
  std::vector<StrokeResult> strokes;
  std::vector<LinkExperimentResult> links;
  std::vector<Figure> figures;     // empty where single experiments were asked for
  std::vector<std::string> peers;  // the libraries that were measured, with versions
};

/// Those of `all` that the options ask for.
std::vector<ExperimentInfo> chosenOf(const std::vector<ExperimentInfo>& all, const SweepOptions& options);

/// The experiments that the options ask for, in the report's order.
std::vector<ExperimentInfo> chosenExperiments(const SweepOptions& options);

/// Ticks of a path.
int ticksOf(const SweepOptions& options);

/// Runs of one setting: each tick's cost is the least of them.
int runsOf(const SweepOptions& options);

/// Runs the sweep in the calling thread; trees are built on several. Takes seconds to minutes.
SweepResult sweep(const SweepOptions& options);

/// Processor, cores and load, in one line.
std::string machineLine();

}  // namespace tandem::client::report
