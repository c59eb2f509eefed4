#pragma once

// Two sites on one part in the report's JSON. For report_json.cpp.

#include <nlohmann/json_fwd.hpp>

#include "client/report/sweep.h"

namespace tandem::client::report {

nlohmann::ordered_json linkExperimentJson(const LinkExperimentResult& e);

}  // namespace tandem::client::report
