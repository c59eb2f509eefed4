#include "client/report/sweep_options.h"

#include <algorithm>

namespace tandem::client::report {

std::vector<ExperimentInfo> chosenOf(const std::vector<ExperimentInfo>& all, const SweepOptions& options) {
  std::vector<ExperimentInfo> chosen;
  for (const ExperimentInfo& info : all) {
    const bool named = std::find(options.only.begin(), options.only.end(), info.id) != options.only.end();
    if (options.only.empty() ? !options.quick || info.quick : named) chosen.push_back(info);
  }
  return chosen;
}

}  // namespace tandem::client::report
