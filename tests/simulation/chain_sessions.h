#pragma once

// Boxes in a row, each held by another site; the first site pushes the row and pulls back. Scenes and
// scenarios are made in code.

#include <string>
#include <vector>

#include "client/simulation/simulation.h"

namespace tandem::test {

struct Chain {
  std::vector<double> masses;  // kg, an owner each
  double delay = 50.0;         // ms, one way
  double deviceForce = 3.3;    // N, the limit of each device
  bool wall = true;            // behind the last box; else the row is free
  haptics::ArmParameters arm;
  double push = 0.06;  // m
};

/// A row of `owners` boxes of 0.05 and 5 kg in turn.
Chain unequalChain(int owners);
std::string describe(const Chain& chain);
client::SimulationResult run(const Chain& chain, const client::SimulationOptions& options);

}  // namespace tandem::test
