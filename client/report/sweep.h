#pragma once

// Speed against error: every experiment with every setting, in this process. Costs are measured, forces
// compared with exact answers.

#include <string>
#include <vector>

#include "client/report/sweep_options.h"
#include "client/report/sweep_results.h"

namespace tandem::client::report {

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
