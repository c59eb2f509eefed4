#pragma once

// What tests of links have in common: bounds of every run, how many seeds, and the control that must fail.

#include "haptics/link_bench/link_runs.h"

namespace tandem::test {

using namespace bench;  // NOLINT: the tests' own subject

void expectPassive(const Tally& tally, const char* what);

/// Seeds of a run: a few, or 20 with TANDEM_FULL_SIZE.
int seeds(int few = 2);

/// A link whose wave goes on as it last was where it has run dry, with its energy: must fail.
LinkEndMaker holdingTheLastWave(const Network& network);

}  // namespace tandem::test
