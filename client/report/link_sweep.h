#pragma once

// Speed against error across the network: the link of sessions with every combination of its knobs, and what it replaces,
// at every delay.

#include <vector>

#include "client/report/link_measurement.h"
#include "client/report/sweep.h"

namespace tandem::client::report {

/// In the report's order: one a delay.
std::vector<ExperimentInfo> allLinkExperiments();
std::vector<ExperimentInfo> chosenLinkExperiments(const SweepOptions& options);

/// All settings at one delay; seconds.
LinkExperimentResult sweepLinks(const ExperimentInfo& info, const SweepOptions& options);

/// s, one way.
double delayOf(const ExperimentInfo& info);

/// Of the gains that are tried, those that feel stiffest from hand to hand, are stable in every run, stay so with half as
/// much stiffness more, and take of the leader at most twice the force without a network. Zero gains: there are none.
/// A minute.
SpringGains searchGains(Architecture architecture, double delay, int seeds);
/// What that search found with 3 seeds.
SpringGains knownGains(Architecture architecture, double delay);

}  // namespace tandem::client::report
