#pragma once

// Across the network: the report's section on two sites that share a part.

#include <string>
#include <vector>

#include "client/report/bound.h"
#include "client/report/sweep_results.h"

namespace tandem::client::report {

/// Empty if nothing of it was measured.
std::string linkSection(const SweepResult& result);

/// "25 ms one way".
std::string delayInWords(const LinkExperimentResult& e);

/// Adds the targets for the link in use at this delay.
void linkBounds(const LinkExperimentResult& e, std::vector<Bound>& bounds);

}  // namespace tandem::client::report
