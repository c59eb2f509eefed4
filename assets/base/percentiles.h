#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace tandem {

/// Nearest-rank percentiles, in the unit of the samples.
struct Percentiles {
  double p50 = 0.0, p99 = 0.0, p999 = 0.0, max = 0.0;
};

/// Percentiles of samples; all zero without samples.
inline Percentiles percentiles(std::vector<double> samples) {
  if (samples.empty()) return {};
  std::sort(samples.begin(), samples.end());
  const auto at = [&](double share) {
    const auto rank = static_cast<std::size_t>(share * static_cast<double>(samples.size()));
    return samples[std::min(rank, samples.size() - 1)];
  };
  return {at(0.5), at(0.99), at(0.999), samples.back()};
}

}  // namespace tandem
