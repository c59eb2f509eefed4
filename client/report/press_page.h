#pragma once

// The parts of the report's page that are about irregular parts pressed onto each other, and about what a
// tick costs against the density of samples and the size of its manifold. For html.cpp.

#include <string>
#include <vector>

#include "client/report/bound.h"
#include "client/report/sweep_results.h"

namespace tandem::client::report {

/// Explanation, plots and tables; empty if there was no such experiment.
std::string pressSection(const SweepResult& result);

/// Of held parts and presses together; empty if there were none.
std::string manifoldSection(const SweepResult& result);

/// Adds the project's targets for this experiment, for Tandem as it is used. Adds the heap allocations to
/// `allocations` and sets `counted` where they were counted.
void pressBounds(const PressResult& e, std::vector<Bound>& bounds, bool& counted, double& allocations);

}  // namespace tandem::client::report
