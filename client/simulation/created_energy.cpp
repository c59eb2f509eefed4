#include "client/simulation/created_energy.h"

#include <algorithm>
#include <numeric>

#include "assets/base/assert.h"

namespace tandem::client {

CreatedEnergy::CreatedEnergy(std::size_t hands) : group_(hands), created_(hands, 0.0) {
  std::iota(group_.begin(), group_.end(), std::size_t{0});
}

void CreatedEnergy::couple(std::size_t a, std::size_t b) {
  const std::size_t kept = group_[a], joined = group_[b];
  if (kept != joined) std::replace(group_.begin(), group_.end(), joined, kept);
}

void CreatedEnergy::add(std::span<const double> given) {
  ASSERT(given.size() == group_.size());
  for (std::size_t group = 0; group < group_.size(); ++group) {
    double sum = 0.0, received = 0.0, before = 0.0;
    for (std::size_t i = 0; i < given.size(); ++i) {
      if (group_[i] != group) continue;
      sum += given[i];
      received += std::max(0.0, given[i]);
      before += created_[i];
    }
    if (sum <= before) continue;
    for (std::size_t i = 0; i < given.size(); ++i)
      if (group_[i] == group) created_[i] = sum * std::max(0.0, given[i]) / received;
  }
}

}  // namespace tandem::client
