// Owners in rows and trees, some of which push further than their devices can give. What a device does not
// give its hand, the row must not get either, and a push goes on through parts that other sites simulate.
// TANDEM_FULL_SIZE runs all sizes and prints the figures; TANDEM_FIRST_SEED is then the first chain drawn.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>

#include "tests/simulation/bounds.h"
#include "tests/simulation/chain_sessions.h"
#include "tests/simulation/shared_sessions.h"
#include "tests/support/full_size.h"

namespace tandem::test {
namespace {

constexpr double kStepBound = 0.5;                      // N in 20 ms
constexpr double kApartBound = 0.010, kApartTo = 50.0;  // m, to this many ms one way

/// A wall stops a hand at the speed that the person has chosen: what a pusher feels of that without any other
/// owner is not the chain's.
double stepBound(const Chain& chain, std::uint64_t seed) {
  double bound = kStepBound;
  if (!chain.wall) return bound;
  for (const std::size_t pusher : chain.pushers)
    bound = std::max(bound, measure(aloneAtWall(chain, pusher), seed).step);
  return bound;
}

/// Judges energy, steps of force while hands push, and how far replicas part.
void expectQuiet(const Chain& chain, std::uint64_t seed) {
  SCOPED_TRACE(describe(chain) + ", seed " + std::to_string(seed));
  const ChainFigures figures = measure(chain, seed);
  const double bound = figures.step > kStepBound ? stepBound(chain, seed) : kStepBound;
  EXPECT_LE(figures.created, kEnergyBound);
  EXPECT_LE(figures.step, bound);
  if (chain.delay <= kApartTo) {
    EXPECT_LE(figures.apart, kApartBound);
  }
  EXPECT_EQ(figures.broken, 0u);
  if (atFullSize())
    std::printf("seed %llu: %s: created %.2f mJ, %.2f N (bound %.2f), apart %.1f mm\n",
                static_cast<unsigned long long>(seed), describe(chain).c_str(), 1e3 * figures.created,
                figures.step, bound, 1e3 * figures.apart);
}

Chain firmRow(int owners, double delay, bool wall) {
  Chain chain = unequalChain(owners);
  chain.delay = delay;
  chain.wall = wall;
  chain.arm = firmArm();
  return chain;
}

TEST(OwnersInARow, MakeNoEnergyWithDevicesAtTheirLimit) {
  expectQuiet(firmRow(3, 50.0, true), 1);
  expectQuiet(firmRow(3, 250.0, false), 1);
  if (!atFullSize()) return;
  for (const int owners : {2, 3, 4, 6, 8})
    for (const double delay : {5.0, 50.0, 100.0, 250.0})
      for (const bool wall : {true, false}) expectQuiet(firmRow(owners, delay, wall), 1);
}

TEST(OwnersInARow, MakeEnergyOnlyWhereTicksDoNotKnowTheLimits) {
  const Chain chain = firmRow(2, 100.0, true);
  expectQuiet(chain, 1);
  const ChainFigures unlimited = measure(chain, 1, client::Mistake::limitsUnknown);
  EXPECT_GT(unlimited.created, 10.0 * kEnergyBound);
  EXPECT_GT(unlimited.step, 2.0 * kStepBound);
}

TEST(OwnersInRowsAndTrees, MakeNoEnergyWhoeverPushes) {
  const char* const first = std::getenv("TANDEM_FIRST_SEED");
  const std::uint64_t from = atFullSize() && first != nullptr ? std::strtoull(first, nullptr, 10) : 1;
  constexpr std::size_t kFew = 3;  // owners
  for (std::uint64_t seed = from; seed < from + (atFullSize() ? 40 : 12); ++seed) {
    const Chain chain = drawChain(seed);
    if (atFullSize() || chain.masses.size() <= kFew) expectQuiet(chain, seed);
  }
}

}  // namespace
}  // namespace tandem::test
