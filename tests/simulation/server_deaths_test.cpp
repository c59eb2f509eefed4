// Several hands pull at one part and hold still while the server dies, once or many times, and while the
// owner's program pauses: no hand may feel it. Timings are drawn by seeds; TANDEM_FULL_SIZE runs more of them
// and prints the figures.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>
#include <random>
#include <vector>

#include "tests/simulation/bounds.h"
#include "tests/simulation/shared_sessions.h"
#include "tests/support/full_size.h"

namespace tandem::test {
namespace {

constexpr double kBound = 0.3;     // N in 20 ms
constexpr double kTension = 0.25;  // N at the most loaded hand, so that there is something to be felt
constexpr double kStill = 3.0;     // s after the last grasp: all have pulled and hold still

using Kind = client::Fault::Kind;

/// Sites in a circle that grasp the block in turn, then each pulls outwards.
struct Pull {
  std::size_t sites = 6;
  double delay = 25.0;  // ms, one way
  double by = 0.012;    // m
  double lasts = 10.0;  // s, from still() on
  std::uint64_t seed = 1;
  std::vector<client::Fault> faults;

  double still() const { return 0.5 + static_cast<double>(sites) + kStill; }
};

nlohmann::json scriptOfPull(const Pull& pull, std::size_t site) {
  const double angle = 2.0 * 3.14159265358979 * static_cast<double>(site) / static_cast<double>(pull.sites);
  const std::vector<double> by{pull.by * std::cos(angle), pull.by * std::sin(angle), 0.0};
  nlohmann::json script = nlohmann::json::array();
  script.push_back(
      {{"t", 0.5 + static_cast<double>(site)}, {"do", "grasp"}, {"part", "block"}, {"over_s", 0.5}});
  script.push_back({{"t", pull.still() - 2.0}, {"do", "move_relative"}, {"by", by}, {"over_s", 0.6}});
  return script;
}

struct Felt {
  std::vector<double> step;   // N in 20 ms, by site, since all hold still
  std::vector<double> force;  // N, by site, when they began to
  double tension() const { return *std::max_element(force.begin(), force.end()); }
  double largest(std::size_t first) const {
    return *std::max_element(step.begin() + static_cast<std::ptrdiff_t>(first), step.end());
  }
};

Felt runPull(const Pull& pull) {
  SharedSession session("shared_drag");
  session.setDelay(pull.delay);
  session.options.seed = pull.seed;
  session.scenario.sites.assign(pull.sites, client::ScenarioSite(session.scenario.sites[0]));
  for (std::size_t i = 0; i < pull.sites; ++i) {
    session.scenario.sites[i].name = std::string(1, static_cast<char>('a' + i));
    session.scenario.sites[i].script = scriptOfPull(pull, i).dump();
    session.arm(i) = relaxedArm();
  }
  session.scenario.faults = pull.faults;
  session.scenario.duration = pull.still() + pull.lasts;
  std::vector<std::vector<glm::dvec3>> forces(pull.sites);
  Felt felt{std::vector<double>(pull.sites, 0.0), std::vector<double>(pull.sites, 0.0)};
  session.options.watch = [&](double t, std::span<const client::SimulatedSiteState> sites) {
    if (t < pull.still() - 0.1) return;
    for (std::size_t i = 0; i < sites.size(); ++i) {
      std::vector<glm::dvec3>& force = forces[i];
      force.push_back(sites[i].force);
      if (force.size() == 1) felt.force[i] = glm::length(sites[i].force);
      felt.step[i] = std::max(felt.step[i], changeIn20ms(force, force.size() - 1));
    }
  };
  const client::SimulationResult result = session.run();
  EXPECT_TRUE(result.violations.empty()) << describe(result);
  EXPECT_LE(result.energyOfLinks, kEnergyBound);
  for (const auto& [name, site] : result.sites) EXPECT_LE(site.energyCreated, kEnergyBound) << name;
  return felt;
}

/// A pull whose timings its seed draws.
struct Drawn {
  explicit Drawn(std::uint64_t seed) : random(seed * 0x9e3779b97f4a7c15ull + 5) {
    pull.seed = seed;
    pull.delay = in(8.0, 50.0);
    pull.by = in(0.008, 0.014);
  }
  double in(double low, double high) {
    return low + (high - low) * std::generate_canonical<double, 32>(random);
  }
  Pull pull;
  std::mt19937_64 random;
};

void printPull(const char* what, const Pull& pull, double step) {
  if (atFullSize())
    std::printf("%s, seed %d: %zu sites, %.0f ms, %.1f mm: %.3f N in 20 ms\n", what,
                static_cast<int>(pull.seed), pull.sites, pull.delay, 1e3 * pull.by, step);
}

TEST(ServerDeaths, SixWhoPullFeelNothingWhileTheOwnerPausesToo) {
  for (std::uint64_t seed = 1; seed <= (atFullSize() ? 40u : 4u); ++seed) {
    Drawn drawn(seed);
    Pull& pull = drawn.pull;
    const double dies = pull.still() + drawn.in(0.0, 0.5);
    pull.faults = {{Kind::killServer, dies, drawn.in(0.1, 0.6), ""},
                   {Kind::pauseSite, dies + drawn.in(-0.1, 0.4), drawn.in(0.2, 1.0), "a"}};
    pull.lasts = 6.0;
    const Felt felt = runPull(pull);
    printPull("the owner pauses", pull, felt.largest(1));
    EXPECT_GT(felt.tension(), kTension) << "seed " << seed;
    EXPECT_LE(felt.largest(1), kBound) << "seed " << seed;
  }
}

TEST(ServerDeaths, EightInSixSecondsAreNotFelt) {
  for (std::uint64_t seed = 1; seed <= (atFullSize() ? 40u : 4u); ++seed) {
    Drawn drawn(seed);
    Pull& pull = drawn.pull;
    pull.sites = 2 + seed % 5;
    for (int death = 0; death < 8; ++death)
      pull.faults.push_back(
          {Kind::killServer, pull.still() + 0.75 * death + drawn.in(0.0, 0.3), drawn.in(0.05, 0.4), ""});
    const Felt felt = runPull(pull);
    printPull("eight deaths", pull, felt.largest(0));
    EXPECT_GT(felt.tension(), kTension) << "seed " << seed;
    EXPECT_LE(felt.largest(0), kBound) << "seed " << seed;
  }
}

// The control: the hand of a program that pauses loses its force to the device's watchdog, and is seen to.
TEST(ServerDeaths, TheHandWhoseOwnProgramPausesFeelsIt) {
  Pull pull;
  pull.sites = 2;
  pull.faults = {{Kind::pauseSite, pull.still() + 0.3, 0.5, "b"}};
  pull.lasts = 1.0;
  EXPECT_GT(runPull(pull).step[1], kBound);
}

}  // namespace
}  // namespace tandem::test
