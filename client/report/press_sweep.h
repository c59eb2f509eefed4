#pragma once

// Irregular parts pressed onto each other, with several densities of samples, and at the samples alone.

#include <vector>

#include "client/report/part_measurement.h"
#include "client/report/press_experiment.h"
#include "client/report/sweep_options.h"
#include "client/report/sweep_results.h"

namespace tandem::client::report {

/// The experiments that the options ask for, in the report's order.
std::vector<ExperimentInfo> chosenPressExperiments(const SweepOptions& options);

/// Every pair of one family; seconds.
PressResult sweepPresses(const ExperimentInfo& info, const SweepOptions& options);

}  // namespace tandem::client::report
