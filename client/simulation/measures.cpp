#include "client/simulation/measures.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "assets/base/assert.h"

namespace tandem::client {

namespace {
constexpr std::size_t kStepWindow = 20;  // ticks
constexpr double kDiverged = 10.0;       // m from where the hand began
constexpr double kRestMotion = 0.5e-3;   // m peak to peak
constexpr double kRestForceStep = 0.3;   // N in 20 ms
constexpr std::size_t kRestTicks = 1500;
}  // namespace

void HandMeasures::add(const HandSample& sample) {
  double largestSquare = 0.0;
  const std::size_t first = samples_.size() >= kStepWindow ? samples_.size() - kStepWindow : 0;
  for (std::size_t i = first; i < samples_.size(); ++i) {
    const glm::dvec3 change = sample.force - samples_[i].force;
    largestSquare = std::max(largestSquare, glm::dot(change, change));
  }
  forceChanges_.push_back(std::sqrt(largestSquare));
  samples_.push_back(sample);
}

double HandMeasures::feltStiffness() const {
  // The axis is the mean force while pressing; force and travel are taken along it.
  glm::dvec3 meanPosition(0.0), meanForce(0.0);
  double count = 0.0;
  for (const HandSample& s : samples_)
    if (s.pressing) {
      meanPosition += s.position;
      meanForce += s.force;
      count += 1.0;
    }
  if (count < 20.0) return 0.0;
  meanPosition /= count;
  meanForce /= count;
  const double norm = glm::length(meanForce);
  if (norm < 1e-9) return 0.0;
  const glm::dvec3 axis = meanForce / norm;
  double xx = 0.0, xf = 0.0;
  for (const HandSample& s : samples_)
    if (s.pressing) {
      const double x = glm::dot(s.position - meanPosition, axis);
      xx += x * x;
      xf += x * glm::dot(s.force - meanForce, axis);
    }
  return xx > 1e-12 ? -xf / xx : 0.0;
}

double HandMeasures::forceStep() const {
  return samples_.empty() ? 0.0 : *std::max_element(forceChanges_.begin(), forceChanges_.end());
}

double HandMeasures::handoverExcess() const {
  double excess = 0.0;
  for (const std::size_t change : roleChanges_) {
    std::vector<double> before;
    for (std::size_t i = change >= 1000 ? change - 1000 : 0; i < change; ++i)
      before.push_back(forceChanges_[i]);
    if (before.empty()) continue;
    const std::size_t rank = before.size() * 99 / 100;
    std::nth_element(before.begin(), before.begin() + static_cast<std::ptrdiff_t>(rank), before.end());
    double after = 0.0;
    // A window that reaches back before the change would count the motion before it: of the first 20 ms, only
    // the change against the last force before is taken.
    for (std::size_t i = change + kStepWindow; i < std::min(change + 500, samples_.size()); ++i)
      after = std::max(after, forceChanges_[i]);
    for (std::size_t i = change; i < std::min(change + kStepWindow, samples_.size()); ++i)
      if (change > 0) after = std::max(after, glm::length(samples_[i].force - samples_[change - 1].force));
    excess = std::max(excess, after - before[rank]);
  }
  return excess;
}

bool HandMeasures::pushed() const {
  return std::any_of(samples_.begin(), samples_.end(), [](const HandSample& s) { return s.pushed; });
}

double HandMeasures::maxForce() const {
  double largest = 0.0;
  for (const HandSample& s : samples_) largest = std::max(largest, glm::length(s.force));
  return largest;
}

double HandMeasures::rmsForce() const {
  if (samples_.empty()) return 0.0;
  double sum = 0.0;
  for (const HandSample& s : samples_) sum += glm::dot(s.force, s.force);
  return std::sqrt(sum / static_cast<double>(samples_.size()));
}

bool HandMeasures::slidOff() const {
  const std::size_t n = samples_.size();
  return n > 1 && samples_[n - 2].brushes && !samples_[n - 1].brushes;
}

bool HandMeasures::restsUnshaken(const std::vector<bool>& undisturbed, bool brushed) const {
  ASSERT(undisturbed.size() == samples_.size());
  for (const HandSample& s : samples_)
    if (!(glm::length(s.position - samples_.front().position) < kDiverged)) return false;
  std::size_t stillFor = 0;
  for (std::size_t i = 0; i < samples_.size(); ++i) {
    stillFor = undisturbed[i] && (brushed || !samples_[i].brushes) ? stillFor + 1 : 0;
    // An arm needs half a second to settle after its target has come to rest.
    if (stillFor > 500 && forceChanges_[i] > kRestForceStep) return false;
  }
  return true;
}

bool HandMeasures::calm(const std::vector<bool>& undisturbed) const {
  return restsUnshaken(undisturbed, false);
}

bool HandMeasures::stable(const std::vector<bool>& allStill) const {
  if (!restsUnshaken(allStill, true)) return false;
  const auto end = allStill.rend(), moving = std::find(allStill.rbegin(), end, false);
  if (moving - allStill.rbegin() < static_cast<std::ptrdiff_t>(kRestTicks + 500)) return true;
  glm::dvec3 low = samples_.back().position, high = low;
  for (std::size_t i = samples_.size() - kRestTicks; i < samples_.size(); ++i) {
    low = glm::min(low, samples_[i].position);
    high = glm::max(high, samples_[i].position);
  }
  return glm::length(high - low) < kRestMotion;
}

}  // namespace tandem::client
