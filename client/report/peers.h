#pragma once

// Other libraries, measured by a program of its own, so that `tandem` need not link them.

#include <string>

#include "assets/base/result.h"
#include "client/report/sweep_options.h"
#include "client/report/sweep_results.h"

namespace tandem::client::report {

/// bench_peers beside this executable, or empty if it is not there.
std::string peersProgramBesideThis();

/// Runs `program` with the same experiments and reads back what it measured. Minutes for large meshes; its
/// progress goes to stderr.
Result<SweepResult> measurePeers(const std::string& program, const SweepOptions& options);

}  // namespace tandem::client::report
