// Owners in a row whose first one pushes further than its device can give. What the device does not give the
// hand, the row must not get either, and a push goes on through parts that other sites simulate.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <glm/geometric.hpp>

#include "tests/simulation/chain_sessions.h"
#include "tests/simulation/shared_sessions.h"

namespace tandem::test {
namespace {

constexpr double kEnergyBound = 1e-3;                 // J
constexpr double kStepBound = 0.5;                    // N in 20 ms
constexpr double kApartBound = 0.010;                 // m, to 50 ms one way
constexpr double kPushBegins = 2.0, kPushEnds = 6.0;  // s

/// Runs a chain and judges energy, steps of force while the first hand pushes, and how far replicas part.
void expectQuiet(const Chain& chain) {
  SCOPED_TRACE(describe(chain));
  constexpr std::size_t kWindow = 20;  // ticks
  std::vector<std::vector<glm::dvec3>> forces(chain.masses.size());
  double step = 0.0;
  client::SimulationOptions options;
  options.leaderLoad = false;
  options.watch = [&](double t, std::span<const client::SimulatedSiteState> sites) {
    for (std::size_t i = 0; i < sites.size(); ++i) {
      std::vector<glm::dvec3>& of = forces[i];
      of.push_back(sites[i].force);
      if (t > kPushBegins && t < kPushEnds && of.size() > kWindow)
        step = std::max(step, glm::length(of.back() - of[of.size() - 1 - kWindow]));
    }
  };
  const client::SimulationResult result = run(chain, options);
  EXPECT_LE(result.energyCreated, kEnergyBound);
  EXPECT_LE(step, kStepBound);
  EXPECT_LE(result.discrepancyMax, kApartBound);
  EXPECT_TRUE(result.violations.empty()) << describe(result);
}

TEST(OwnersInARow, MakeNoEnergyWithDevicesAtTheirLimit) {
  const bool full = std::getenv("TANDEM_FULL_SIZE") != nullptr;
  for (const int owners : full ? std::vector<int>{2, 3, 4, 6, 8} : std::vector<int>{3})
    for (const double delay : full ? std::vector<double>{10.0, 50.0} : std::vector<double>{50.0})
      for (const bool wall : full ? std::vector<bool>{true, false} : std::vector<bool>{true}) {
        Chain chain = unequalChain(owners);
        chain.delay = delay;
        chain.wall = wall;
        chain.arm = firmArm();
        expectQuiet(chain);
      }
}

}  // namespace
}  // namespace tandem::test
