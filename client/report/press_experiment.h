#pragma once

// Irregular parts pressed onto each other and slid (assets/generate/irregular_shapes.h): no exact force is
// known, but how deep they may be in each other is.

#include <string>
#include <vector>

#include "assets/generate/irregular_shapes.h"
#include "client/report/part_experiment.h"

namespace tandem::client::report {

/// One of each family.
std::vector<ExperimentInfo> allPressExperiments();

/// The id must be one of allPressExperiments().
generate::Family familyOf(const std::string& id);

/// The meshes of a pair, and one way of pressing the held one onto the other.
PartExperiment buildPress(generate::Family family, unsigned pair, unsigned pose);

}  // namespace tandem::client::report
