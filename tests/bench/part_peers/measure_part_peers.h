#pragma once

// The report's experiments with a part in the hand, with what other libraries answer.

#include <string>
#include <vector>

#include "client/report/sweep.h"

namespace tandem::bench {

/// Names and versions of the libraries that this program was built with.
std::vector<std::string> partPeerVersions();

/// One experiment with all of them.
client::report::PartExperimentResult measurePartPeers(const client::report::ExperimentInfo& info,
                                                      const client::report::SweepOptions& options);

}  // namespace tandem::bench
