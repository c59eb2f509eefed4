#include "client/simulation/created_energy.h"

#include <algorithm>

#include "assets/base/assert.h"

namespace tandem::client {

void CreatedEnergy::add(std::span<const double> given) {
  ASSERT(given.size() == created_.size());
  const auto groupOf = [this](std::size_t hand) { return groups_.find(static_cast<std::uint32_t>(hand)); };
  for (std::size_t group = 0; group < given.size(); ++group) {
    double sum = 0.0, received = 0.0, before = 0.0;
    for (std::size_t i = 0; i < given.size(); ++i) {
      if (groupOf(i) != group) continue;
      sum += given[i];
      received += std::max(0.0, given[i]);
      before += created_[i];
    }
    if (sum <= before) continue;
    for (std::size_t i = 0; i < given.size(); ++i)
      if (groupOf(i) == group) created_[i] = sum * std::max(0.0, given[i]) / received;
  }
}

}  // namespace tandem::client
