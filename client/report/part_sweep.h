#pragma once

// Speed against error with a part in the hand: every such experiment with every setting that the code has, in
// this process.

#include <string>
#include <vector>

#include "client/report/part_measurement.h"
#include "client/report/sweep_options.h"
#include "client/report/sweep_results.h"
#include "haptics/scene/contact_scene.h"

namespace tandem::client::report {

/// The experiments that the options ask for, in the report's order.
std::vector<ExperimentInfo> chosenPartExperiments(const SweepOptions& options);

/// Ticks of a path with a part in the hand.
int partTicksOf(const SweepOptions& options);

/// One experiment with all settings; seconds each.
PartExperimentResult sweepPart(const ExperimentInfo& info, const SweepOptions& options);

/// The resolution with which a model is made.
struct Making {
  double field = 1.0, samples = 1.0;
  bool asUsed() const { return field == 1.0 && samples == 1.0; }
};

/// A measurement that has its setting and name only.
PartMeasurement named(const Making& making, const haptics::ContactEffort& effort);

/// Runs the whole tick over the path, `runs` times. `contact` is of experiment.scene; without part models the
/// part passes through. The depth is measured in every `depthEvery`-th tick of the first run. The tick is
/// given out.effort; allocations are added to `out`.
std::vector<std::vector<PartSample>> runPart(const PartExperiment& experiment,
                                             const haptics::ContactScene& contact, int runs, int depthEvery,
                                             std::uint64_t (*allocations)(), PartMeasurement& out);

/// The same, and judges it.
void measureTick(const PartExperiment& experiment, const haptics::ContactScene& contact, int runs,
                 int depthEvery, std::uint64_t (*allocations)(), PartMeasurement& out);

}  // namespace tandem::client::report
