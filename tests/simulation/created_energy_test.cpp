// The energy that a simulation says was created is what its hands together were given, by an integration of
// their devices' forces over their travel that shares no code with it.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <glm/geometric.hpp>

#include "tests/simulation/chain_sessions.h"
#include "tests/simulation/shared_sessions.h"
#include "tests/support/full_size.h"

namespace tandem::test {
namespace {

constexpr double kAgreement = 2e-3;  // J

/// Force times travel of all hands, tick by tick: a device holds its force until the next tick.
class ForceTimesTravel {
 public:
  void add(std::span<const client::SimulatedSiteState> sites) {
    last_.resize(sites.size(), {sites.front().device, {}, false});
    for (std::size_t i = 0; i < sites.size(); ++i) {
      Hand& hand = last_[i];
      if (hand.seen) given_ += glm::dot(hand.force, sites[i].device - hand.at);
      hand = {sites[i].device, sites[i].force, true};
    }
    most_ = std::max(most_, given_);
  }
  double most() const { return most_; }

 private:
  struct Hand {
    glm::dvec3 at, force;
    bool seen;
  };
  std::vector<Hand> last_;
  double given_ = 0.0, most_ = 0.0;  // J
};

/// Runs a chain and returns the energy that its hands were given; the simulation must say the same.
double created(const Chain& chain, client::Mistake mistake, std::uint64_t seed) {
  ForceTimesTravel independent;
  client::SimulationOptions options;
  options.leaderLoad = false;
  options.seed = seed;
  options.mistake = mistake;
  options.watch = [&](double, std::span<const client::SimulatedSiteState> sites) { independent.add(sites); };
  const client::SimulationResult result = run(chain, options);
  EXPECT_NEAR(result.energyCreated, independent.most(), kAgreement) << describe(chain) << ", seed " << seed;
  // No honest site is doubted, however far its device's limit holds it back.
  if (mistake == client::Mistake::none) {
    for (const client::Violation& broken : result.violations)
      ADD_FAILURE() << describe(chain) << ": " << broken.what;
  }
  double sum = 0.0;
  for (const auto& [name, site] : result.sites) sum += site.energyCreated;
  EXPECT_NEAR(sum, result.energyCreated, 1e-12);
  if (atFullSize())
    std::printf("%s: said %.2f mJ, given %.2f mJ\n", describe(chain).c_str(), 1e3 * result.energyCreated,
                1e3 * independent.most());
  return independent.most();
}

TEST(CreatedEnergyOfSessions, IsWhatTheHandsTogetherWereGiven) {
  const bool full = atFullSize();
  for (const int owners : full ? std::vector<int>{2, 3, 4, 6} : std::vector<int>{2, 3})
    for (const double delay : full ? std::vector<double>{5.0, 50.0, 100.0, 250.0} : std::vector<double>{50.0})
      for (const double force : {1.0, 3.3, 30.0}) {
        Chain chain = unequalChain(owners);
        chain.delay = delay;
        chain.deviceForce = force;
        chain.wall = owners % 2 == 1 || full;
        chain.arm = firmArm();
        created(chain, client::Mistake::none, 1);
      }
}

TEST(CreatedEnergyOfSessions, ASourceInEveryDeviceIsSeen) {
  for (const double force : {3.3, 30.0}) {
    Chain chain = unequalChain(2);
    chain.deviceForce = force;
    chain.wall = false;
    chain.arm = relaxedArm();
    EXPECT_GT(created(chain, client::Mistake::negativeDamping, 1) - created(chain, client::Mistake::none, 1),
              1e-3)
        << force;
  }
}

}  // namespace
}  // namespace tandem::test
