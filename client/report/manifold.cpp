#include "client/report/manifold.h"

#include <map>

#include "assets/base/percentiles.h"

namespace tandem::client::report {
namespace {

/// The smallest number of rows of the bin that holds `rows`: 1, 2, 3, 4, 6, 8, 12, 16, ...
int binOf(int rows) {
  int low = 1;
  while (2 * low <= rows) low *= 2;
  return low >= 2 && 2 * rows >= 3 * low ? 3 * low / 2 : low;
}

}  // namespace

std::vector<ManifoldBin> manifoldBins(const std::vector<RowsAndCost>& ticks) {
  std::map<int, std::vector<RowsAndCost>> bins;
  for (const RowsAndCost& tick : ticks)
    if (tick.rows > 0) bins[binOf(tick.rows)].push_back(tick);
  std::vector<ManifoldBin> found;
  for (const auto& [low, members] : bins) {
    if (members.size() < kLeastTicks) continue;
    std::vector<double> us;
    double rows = 0.0;
    for (const RowsAndCost& tick : members) {
      us.push_back(tick.us);
      rows += tick.rows;
    }
    const Percentiles cost = percentiles(us);
    found.push_back({rows / static_cast<double>(members.size()), members.size(), cost.p50, cost.p99});
  }
  return found;
}

}  // namespace tandem::client::report
