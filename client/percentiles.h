#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace tandem::client {

struct Percentiles {
  double p50 = 0.0, p99 = 0.0, p999 = 0.0, max = 0.0;
};

/// Nearest-rank percentiles; zeros for no values.
inline Percentiles percentiles(std::vector<double> values) {
  if (values.empty()) return {};
  std::sort(values.begin(), values.end());
  const auto rank = [&](double share) {
    return values[std::min(values.size() - 1,
                           static_cast<std::size_t>(share * static_cast<double>(values.size())))];
  };
  return {rank(0.5), rank(0.99), rank(0.999), values.back()};
}

}  // namespace tandem::client
