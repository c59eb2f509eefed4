#pragma once

// The JSON that all kinds of experiments have in common. For the files that write reports.

#include "assets/base/json.h"
#include "client/report/measurement.h"

namespace tandem::client::report {

/// null where it is not finite.
Json numberJson(double value);
const char* nameOf(Kind kind);

/// Puts `cost_us` into the object of a setting, and `error_n` and `error_share`.
void putCost(Json& setting, const Cost& cost);
void putError(Json& setting, const ForceError& error);

/// A number of the object, finite and not negative. These throw JsonError at anything else.
double measure(const Json& object, const char* key);
Cost costFrom(const Json& setting);
ForceError errorFrom(const Json& setting);

}  // namespace tandem::client::report
