#pragma once

// Experiments with a part in the hand as JSON, and peers' figures back from it. For report_json.cpp.

#include <nlohmann/json_fwd.hpp>

#include "client/report/sweep.h"

namespace tandem::client::report {

nlohmann::ordered_json partExperimentJson(const PartExperimentResult& e);

/// What a program that measures peers wrote for one experiment; throws nlohmann's exceptions at what is no measure.
PartExperimentResult partPeersFromJson(const nlohmann::ordered_json& entry);

}  // namespace tandem::client::report
