#pragma once

// The report's figures as JSON, and the peers' figures back from it. Costs in us, forces in N, lengths in m.

#include <string>

#include "assets/base/result.h"
#include "client/report/sweep_results.h"

namespace tandem::client::report {

/// One object; see client/report/JSON.md for its fields. Numbers that are not finite become null.
std::string toJson(const SweepResult& result);

/// What a program that measures peers wrote: {"peers":[NAME..],"experiments":[{"id":..,"settings":[..]}..]}
/// with the fields of toJson().
Result<SweepResult> peersFromJson(const std::string& text);

/// Adds the peers' settings to the experiments of the same id.
void mergePeers(const SweepResult& peers, SweepResult& result);

}  // namespace tandem::client::report
