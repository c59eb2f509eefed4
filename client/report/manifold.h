#pragma once

// What a tick costs against the size of the manifold that it solves.

#include <cstddef>
#include <vector>

namespace tandem::client::report {

/// A tick.
struct RowsAndCost {
  int rows = 0;
  double us = 0.0;
};

/// The ticks with about as many rows.
struct ManifoldBin {
  double rows = 0.0;  // on average
  std::size_t ticks = 0;
  double p50 = 0.0, p99 = 0.0;  // us
};

/// In order of rising rows: every number of rows up to three is a bin of its own, and then two bins for each
/// doubling. Ticks without rows, and bins of fewer than kLeastTicks, are left out.
std::vector<ManifoldBin> manifoldBins(const std::vector<RowsAndCost>& ticks);
inline constexpr std::size_t kLeastTicks = 5;

}  // namespace tandem::client::report
