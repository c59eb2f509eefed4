#pragma once

// The scripts of a scenario's people, which can be read once its scene is known.

#include <vector>

#include "assets/base/result.h"
#include "client/hand/hand_script.h"
#include "client/simulation/scenario.h"

namespace tandem::client {

/// The script of each site, in their order. An error names the scenario, the site, the step and the reason.
Result<std::vector<HandScript>> parseScripts(const Scenario& scenario, const assets::Scene& scene);

}  // namespace tandem::client
