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

double rms(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double v : values) sum += v * v;
  return values.empty() ? 0.0 : std::sqrt(sum / static_cast<double>(values.size()));
}

}  // namespace

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
  const std::vector<glm::dvec3>& force = runs.front().force;
  std::vector<double> absolute, relative, least = runs.front().us;
  for (std::size_t i = 0; i < ticks; ++i) {
    absolute.push_back(glm::length(force[i] - exact[i]));
    const double strength = glm::length(exact[i]);
    if (strength >= kWeak * peak) relative.push_back(absolute.back() / strength);
    for (const Samples& run : runs) least[i] = std::min(least[i], run.us[i]);
    if (i == 0) continue;
    const glm::dvec3 change = force[i] - force[i - 1], ideal = exact[i] - exact[i - 1];
    out.step.measured = std::max(out.step.measured, glm::length(change));
    out.step.ideal = std::max(out.step.ideal, glm::length(ideal));
    out.step.excess = std::max(out.step.excess, glm::length(change - ideal));
  }
  const Percentiles cost = percentiles(least), a = percentiles(absolute), r = percentiles(relative);
  out.cost = {cost.p50, cost.p99, cost.max, percentiles(runs.front().us).p99};
  out.error = {rms(absolute), a.p99, a.max, rms(relative), r.p99, r.max};
}

}  // namespace tandem::client::report
