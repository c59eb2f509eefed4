#pragma once

// The part of the report's page that is about a part in the hand. For html.cpp.

#include <string>
#include <vector>

#include "client/report/bound.h"
#include "client/report/sweep_results.h"

namespace tandem::client::report {

/// Explanation, plots and tables; empty if there was no such experiment.
std::string partSection(const SweepResult& result);

/// Adds the project's targets for this experiment, for Tandem as it is used. Adds the heap allocations to
/// `allocations` and sets `counted` where they were counted.
void partBounds(const PartExperimentResult& e, std::vector<Bound>& bounds, bool& counted,
                double& allocations);

}  // namespace tandem::client::report
