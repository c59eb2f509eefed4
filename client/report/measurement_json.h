#pragma once

// What the figures of every setting have in common in JSON, whatever the experiment. For the files that write reports.

#include <nlohmann/json_fwd.hpp>

#include "client/report/measurement.h"

namespace tandem::client::report {

/// null where it is not finite.
nlohmann::ordered_json number(double value);
const char* nameOf(Kind kind);

/// Puts `cost_us` into the object of a setting, and `error_n` and `error_share`.
void putCost(nlohmann::ordered_json& setting, const Cost& cost);
void putError(nlohmann::ordered_json& setting, const ForceError& error);

/// A number of the object, finite and not negative. These throw nlohmann's exceptions at what is no measure.
double measure(const nlohmann::ordered_json& object, const char* key);
Cost costFrom(const nlohmann::ordered_json& setting);
ForceError errorFrom(const nlohmann::ordered_json& setting);

}  // namespace tandem::client::report
