#include "client/report/measurement.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "assets/base/assert.h"
#include "assets/base/percentiles.h"

namespace tandem::client::report {
namespace {

// Relative errors are taken only where the exact force is at least this share of its peak.
constexpr double kWeak = 0.05;

/// How the force changes from tick to tick.
ForceStep stepsOf(const Experiment& experiment, const std::vector<glm::dvec3>& force,
                  const std::vector<glm::dvec3>& exact) {
  ForceStep step;
  for (std::size_t i = 1; i < force.size(); ++i) {
    const glm::dvec3 change = force[i] - force[i - 1], ideal = exact[i] - exact[i - 1];
    step.measured = std::max(step.measured, glm::length(change));
    step.ideal = std::max(step.ideal, glm::length(ideal));
    step.excess = std::max(step.excess, glm::length(change - ideal));
    const double travel = glm::length(experiment.path[i].device - experiment.path[i - 1].device);
    const double beyond = glm::length(change) - experiment.stiffness * travel;
    step.beyondTravel = std::max(step.beyondTravel, beyond);
    step.jumps += beyond > kFeltJump ? 1 : 0;
  }
  return step;
}

/// The least cost of each tick of all runs, us.
std::vector<double> leastOf(const std::vector<Samples>& runs) {
  std::vector<double> least = runs.front().us;
  for (const Samples& run : runs)
    for (std::size_t i = 0; i < least.size(); ++i) least[i] = std::min(least[i], run.us[i]);
  return least;
}

/// The cost of the ticks in free space after the first contact.
Cost hoveringCost(const std::vector<glm::dvec3>& exact, const std::vector<double>& least,
                  const std::vector<double>& single) {
  std::vector<double> leastThere, singleThere;
  bool touched = false;
  for (std::size_t i = 0; i < exact.size(); ++i) {
    touched = touched || exact[i] != glm::dvec3(0.0);
    if (!touched || exact[i] != glm::dvec3(0.0)) continue;
    leastThere.push_back(least[i]);
    singleThere.push_back(single[i]);
  }
  return leastThere.empty() ? Cost{} : costOf(leastThere, singleThere);
}

}  // namespace

double rms(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double v : values) sum += v * v;
  return values.empty() ? 0.0 : std::sqrt(sum / static_cast<double>(values.size()));
}

Cost costOf(const std::vector<double>& least, const std::vector<double>& single) {
  const Percentiles p = percentiles(least);
  return {p.p50, p.p99, p.max, percentiles(single).p99};
}

void judge(const Experiment& experiment, const std::vector<Samples>& runs, Measurement& out) {
  const std::size_t ticks = experiment.path.size();
  ASSERT(!runs.empty());
  for (const Samples& run : runs) ASSERT(run.us.size() == ticks && run.force.size() == ticks);
  std::vector<glm::dvec3> exact;
  double peak = 0.0;
  for (const PathPoint& p : experiment.path) {
    exact.push_back(springForce(experiment.stiffness, p.exactProxy, p.device));
    peak = std::max(peak, glm::length(exact.back()));
  }
  const Samples& first = runs.front();
  std::vector<double> absolute, relative;
  for (std::size_t i = 0; i < ticks; ++i) {
    absolute.push_back(glm::length(first.force[i] - exact[i]));
    const double strength = glm::length(exact[i]);
    if (strength >= kWeak * peak) relative.push_back(absolute.back() / strength);
  }
  for (std::size_t i = 0; i < first.depth.size(); ++i)
    out.beyondDepth =
        std::max(out.beyondDepth, glm::length(first.force[i]) - experiment.stiffness * first.depth[i]);
  const std::vector<double> least = leastOf(runs);
  out.cost = costOf(least, first.us);
  out.hovering = hoveringCost(exact, least, first.us);
  out.step = stepsOf(experiment, first.force, exact);
  const Percentiles a = percentiles(absolute), r = percentiles(relative);
  out.error = {rms(absolute), a.p99, a.max, rms(relative), r.p99, r.max};
}

}  // namespace tandem::client::report
