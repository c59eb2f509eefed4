#include "client/report/part_measurement.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "assets/base/assert.h"
#include "assets/base/percentiles.h"

namespace tandem::client::report {
namespace {

Spread spreadOf(const std::vector<double>& values) {
  const Percentiles p = percentiles(values);
  return {p.p50, p.p99, p.max};
}

double angleBetween(const glm::dvec3& a, const glm::dvec3& b) {
  return std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b));
}

/// Sets what ticks cost, in all and by the size of their manifold.
void judgeCost(const std::vector<std::vector<PartSample>>& runs, PartMeasurement& out) {
  std::vector<double> least, single;
  std::vector<RowsAndCost> active, solved;
  for (std::size_t i = 0; i < runs.front().size(); ++i) {
    const PartSample& first = runs.front()[i];
    if (first.us < 0.0) continue;
    single.push_back(first.us);
    least.push_back(first.us);
    for (const std::vector<PartSample>& run : runs) least.back() = std::min(least.back(), run[i].us);
    active.push_back({first.active, least.back()});
    solved.push_back({first.solved, least.back()});
  }
  out.cost = costOf(least, single);
  out.active = manifoldBins(active);
  out.solved = manifoldBins(solved);
}

}  // namespace

bool usualIterations(const haptics::ContactEffort& effort) {
  const haptics::ContactEffort used;
  return effort.steps == used.steps && effort.sampleQueries == used.sampleQueries;
}

void judgePart(const PartExperiment& experiment, const std::vector<std::vector<PartSample>>& runs,
               PartMeasurement& out) {
  ASSERT(!runs.empty());
  for (const std::vector<PartSample>& each : runs) ASSERT(each.size() == experiment.path.size());
  const std::vector<PartSample>& run = runs.front();
  std::vector<double> depth, error, relative, forceStep, forceChange, normalStep;
  std::size_t contacts = 0, found = 0;
  for (std::size_t i = 0; i < run.size(); ++i) {
    const PartPathPoint& point = experiment.path[i];
    if (run[i].us < 0.0) continue;
    const bool follows = i > 0 && run[i - 1].us >= 0.0;
    if (follows) forceChange.push_back(glm::length(run[i].force - run[i - 1].force));
    if (point.depth && run[i].depth >= 0.0) depth.push_back(run[i].depth);
    if (point.force) {
      error.push_back(glm::length(run[i].force - point.exactForce));
      relative.push_back(error.back() / glm::length(point.exactForce));
      if (follows && experiment.path[i - 1].force)
        forceStep.push_back(glm::length((run[i].force - run[i - 1].force) -
                                        (point.exactForce - experiment.path[i - 1].exactForce)));
    }
    if (!point.contact) continue;
    ++contacts;
    found += glm::dot(run[i].normal, point.exactForce) > 0.0 ? 1 : 0;
    if (follows && run[i].normal != glm::dvec3(0.0) && run[i - 1].normal != glm::dvec3(0.0))
      normalStep.push_back(angleBetween(run[i - 1].normal, run[i].normal));
  }
  judgeCost(runs, out);
  out.depth = spreadOf(depth);
  const Spread absolute = spreadOf(error), share = spreadOf(relative);
  out.error = {rms(error), absolute.p99, absolute.max, rms(relative), share.p99, share.max};
  out.forceStep = spreadOf(forceStep);
  out.forceChange = spreadOf(forceChange);
  out.normalStep = spreadOf(normalStep);
  out.found = contacts > 0 ? static_cast<double>(found) / static_cast<double>(contacts) : 0.0;
}

}  // namespace tandem::client::report
