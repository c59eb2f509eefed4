#pragma once

// The sweep across the network: the link of sessions with every combination of its parameters, and the other
// architectures, at every delay.

#include <vector>

#include "client/report/link_measurement.h"
#include "client/report/sweep_options.h"
#include "client/report/sweep_results.h"

namespace tandem::client::report {

/// In the report's order: one a delay.
std::vector<ExperimentInfo> allLinkExperiments();
std::vector<ExperimentInfo> chosenLinkExperiments(const SweepOptions& options);

/// Measures all settings at one delay; takes seconds.
LinkExperimentResult sweepLinks(const ExperimentInfo& info, const SweepOptions& options);

/// The delay one way of an experiment, s.
double delayOf(const ExperimentInfo& info);

/// Searches the gains that feel stiffest from hand to hand, are stable in every run, also with 1.5 times the
/// stiffness, and load the leader with at most twice the force without a network. Zero if there are none.
/// Takes a minute.
SpringGains searchGains(Architecture architecture, double delay, int seeds);
/// The result of that search with 3 seeds.
SpringGains knownGains(Architecture architecture, double delay);

}  // namespace tandem::client::report
