#pragma once

// Experiments with a part in the hand as JSON, and peers' figures back from it. For report_json.cpp.

#include "assets/base/json.h"
#include "client/report/sweep_results.h"

namespace tandem::client::report {

Json partExperimentJson(const PartExperimentResult& e);
Json pressJson(const PressResult& e);

/// Reads what a program that measures peers wrote for one experiment; throws JsonError where that is no
/// measurement.
PartExperimentResult partPeersFromJson(const Json& entry);

}  // namespace tandem::client::report
