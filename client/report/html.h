#pragma once

// The report as one HTML page that needs nothing else: style, pictures and data are inside.

#include <string>

#include "client/report/bound.h"
#include "client/report/sweep_results.h"

namespace tandem::client::report {

/// The bounds that this run can judge; those whose experiments were left out are not listed.
std::vector<Bound> boundsOf(const SweepResult& result);

/// The whole page. `json` is what toJson() gave; it is embedded as data.
std::string htmlPage(const SweepResult& result, const std::string& json);

}  // namespace tandem::client::report
