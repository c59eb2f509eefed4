#pragma once

// Two sites on one part in the report's JSON. For report_json.cpp.

#include "assets/base/json.h"
#include "client/report/sweep_results.h"

namespace tandem::client::report {

Json linkExperimentJson(const LinkExperimentResult& e);

}  // namespace tandem::client::report
