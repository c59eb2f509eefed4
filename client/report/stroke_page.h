#pragma once

// The part of the report that is about strokes through models: page and JSON. For html.cpp and
// report_json.cpp.

#include <string>
#include <vector>

#include "assets/base/json.h"
#include "client/report/bound.h"
#include "client/report/stroke_sweep.h"

namespace tandem::client::report {

/// Explanation, plots and table; empty without models.
std::string strokeSection(const std::vector<StrokeResult>& strokes);

/// That no stroke falls.
void strokeBounds(const StrokeResult& e, std::vector<Bound>& bounds);

Json strokeJson(const StrokeResult& e);

}  // namespace tandem::client::report
