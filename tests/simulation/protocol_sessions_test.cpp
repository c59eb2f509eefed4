// Sessions of the protocol alone, drawn at random with all that can go wrong. Each must keep every rule while
// things go wrong, and serve everybody once all is calm. TANDEM_PROTOCOL_SEEDS sets their number,
// TANDEM_FIRST_SEED the first seed. TANDEM_PROTOCOL_CORPUS names a file to which the seeds are added that
// reach what no seed before them in this run did; those of protocol_seeds.txt run every time.

#include <gtest/gtest.h>

#include <bit>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>

#include "tests/simulation/protocol_draw.h"
#include "tests/support/source_file.h"

// The counters of branches of server and sync. Null unless tests/coverage.py has built them in.
extern "C" {
[[gnu::weak]] std::uint64_t* __llvm_profile_begin_counters();
[[gnu::weak]] std::uint64_t* __llvm_profile_end_counters();
}

namespace tandem::test {
namespace {

std::uint64_t number(const char* variable, std::uint64_t fallback) {
  const char* text = std::getenv(variable);
  return text != nullptr ? std::strtoull(text, nullptr, 10) : fallback;
}

std::string describeProtocol(const client::ProtocolResult& result) {
  std::string text;
  for (const client::Violation& violation : result.violations)
    text += violation.rule + " at " + std::to_string(violation.at) + " s: " + violation.what + "\n";
  return text;
}

/// What sessions reached: branches, in a build that counts them; else each counter of the checker, the server
/// and the sites, to a power of two.
class Reached {
 public:
  /// Whether the session that has just run reached something new.
  bool add(const client::ProtocolResult& result) {
    if (__llvm_profile_begin_counters != nullptr) return addBranches();
    const std::size_t before = seen_.size();
    int counter = 0;
    const auto count = [&](std::uint64_t value) { seen_.insert({counter++, std::bit_width(value)}); };
    for (const std::uint64_t checks : result.checks) count(checks);
    const server::SessionCounters& server = result.server;
    for (const std::uint64_t value :
         {server.droppedStates, server.droppedMalformed, server.droppedBaselines, server.droppedEarly,
          server.relayedLinks, server.droppedLinks, server.droppedFlood, server.holds, server.refusedPoses,
          server.refusedHellos, server.refusedMessages, server.denials, server.expiries, server.releases,
          result.reconnects, result.droppedStates, result.malformed, result.granted})
      count(value);
    return seen_.size() > before;
  }

 private:
  bool addBranches() {
    std::uint64_t* const begin = __llvm_profile_begin_counters();
    const auto count = static_cast<std::size_t>(__llvm_profile_end_counters() - begin);
    branches_.resize(count, false);
    bool isNew = false;
    for (std::size_t i = 0; i < count; ++i) {
      if (begin[i] == 0 || branches_[i]) continue;
      branches_[i] = isNew = true;
    }
    return isNew;
  }

  std::set<std::pair<int, int>> seen_;
  std::vector<bool> branches_;
};

/// Of all sessions of this program.
Reached& reached() {
  static Reached all;
  return all;
}

constexpr int kParts = 4;  // test cases, which can run side by side

class ProtocolSessions : public testing::TestWithParam<int> {};

TEST_P(ProtocolSessions, KeepEveryRuleAndServeEverybodyInTheEnd) {
  client::ProtocolSimulation simulation(protocolScene());
  const std::uint64_t first = number("TANDEM_FIRST_SEED", 1), count = number("TANDEM_PROTOCOL_SEEDS", 200);
  std::array<std::uint64_t, client::kRules> checks{};
  const char* corpus = std::getenv("TANDEM_PROTOCOL_CORPUS");
  std::uint64_t grants = 0, failed = 0;
  for (std::uint64_t i = static_cast<std::uint64_t>(GetParam()); i < count && failed < 5; i += kParts) {
    const std::uint64_t seed = first + i;
    const client::Scenario scenario = drawProtocolSession(seed);
    const Result<client::ProtocolResult> result = simulation.run(scenario, seed);
    ASSERT_TRUE(result.ok()) << result.error().message;
    for (std::size_t rule = 0; rule < checks.size(); ++rule) checks[rule] += result->checks[rule];
    if (reached().add(*result) && corpus != nullptr) std::ofstream(corpus, std::ios::app) << seed << "\n";
    grants += result->grants.size();
    if (result->violations.empty()) continue;
    ++failed;
    const client::Scenario small = minimised(simulation, scenario, seed);
    ADD_FAILURE() << "TANDEM_FIRST_SEED=" << seed << " TANDEM_PROTOCOL_SEEDS=1\n"
                  << describeProtocol(*result) << "the session:\n"
                  << toJson(scenario) << "\nthe smallest that breaks a rule with --seed " << seed << ":\n"
                  << toJson(small) << "\n"
                  << describeProtocol(*simulation.run(small, seed));
  }
  std::printf("%lu grants;", static_cast<unsigned long>(grants));
  for (std::size_t rule = 0; rule < checks.size(); ++rule)
    std::printf(" %s %lu", toString(static_cast<client::Rule>(rule)),
                static_cast<unsigned long>(checks[rule]));
  std::printf("\n");
  if (count < 200) return;
  for (std::size_t rule = 0; rule < checks.size(); ++rule)
    EXPECT_GT(checks[rule], 0u) << toString(static_cast<client::Rule>(rule)) << " was never put to the test";
}

TEST(ProtocolSessionsKept, SeedsThatOnceReachedSomethingNewKeepEveryRule) {
  std::ifstream file(sourceFile("tests/simulation/protocol_seeds.txt"));
  client::ProtocolSimulation simulation(protocolScene());
  int seeds = 0;
  for (std::uint64_t seed = 0; file >> seed; ++seeds) {
    const auto result = simulation.run(drawProtocolSession(seed), seed);
    ASSERT_TRUE(result.ok()) << result.error().message;
    EXPECT_TRUE(result->violations.empty()) << "seed " << seed << "\n" << describeProtocol(*result);
    reached().add(*result);
  }
  EXPECT_GT(seeds, 10);
}

TEST(ProtocolSessionsKept, APartThatWasLetGoWhileTheDiskWasSickIsFreeOnceTheDiskIsWell) {
  client::Scenario scenario = drawProtocolSession(1, 0);
  scenario.sites.resize(2);
  scenario.sites[0].script = R"([{"t": 1, "do": "grasp", "part": "block"}, {"t": 5.3, "do": "release"}])";
  scenario.network = {};
  scenario.network.oneWay = 20 * sync::kMillisecond;
  scenario.duration = 12.0;
  scenario.calmFrom = -1.0;
  scenario.faults = {{client::Fault::Kind::diskSlow, 4.0, 10.0, "", 0.01, ""},
                     {client::Fault::Kind::diskFails, 5.0, 1.0, "", 0.0, ""}};
  // The disk is found to be sick by a grab of another part.
  scenario.sites[1].script = R"([{"t": 5.1, "do": "grasp", "part": "plate"}, {"t": 8, "do": "release"},
                                 {"t": 9, "do": "grasp", "part": "block"}])";
  client::ProtocolSimulation simulation(protocolScene());
  const auto result = simulation.run(scenario, 1);
  ASSERT_TRUE(result.ok()) << result.error().message;
  EXPECT_TRUE(result->violations.empty()) << describeProtocol(*result);
  ASSERT_FALSE(result->grants.empty());
  EXPECT_EQ(result->grants.back().part, result->grants.front().part);
  EXPECT_NE(result->grants.back().site, result->grants.front().site) << "still with who let it go";
}

TEST(ProtocolSessionsKept, TheSameSeedGivesTheSameSessionFromItsTextToo) {
  client::ProtocolSimulation simulation(protocolScene());
  const std::string path = testing::TempDir() + "protocol_session.json";
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const client::Scenario scenario = drawProtocolSession(seed, kAnyFaults, seed % 10 == 0);
    std::ofstream(path) << toJson(scenario);
    const Result<client::Scenario> read = client::loadScenario(path);
    ASSERT_TRUE(read.ok()) << read.error().message;
    const auto first = simulation.run(scenario, seed), again = simulation.run(scenario, seed),
               fromText = simulation.run(*read, seed);
    ASSERT_TRUE(first.ok() && again.ok() && fromText.ok());
    EXPECT_EQ(first->hash, again->hash) << seed;
    EXPECT_EQ(first->hash, fromText->hash) << seed;
  }
}

TEST(ProtocolSessionsKept, ASeedDrawsTheSameSessionWhateverTheCompiler) {
  std::uint64_t hash = 0xcbf29ce484222325ull;  // FNV-1a
  for (std::uint64_t seed = 1; seed <= 100; ++seed)
    for (const char letter : toJson(drawProtocolSession(seed, kAnyFaults, seed % 10 == 0)))
      hash = (hash ^ static_cast<unsigned char>(letter)) * 0x100000001b3ull;
  EXPECT_EQ(hash, 0x1545d39cf5e742cfu)
      << std::hex << hash << ": if the drawing changed, protocol_seeds.txt means other sessions";
}

/// Every fault and every step of a script that is left is needed for the rule to be broken.
void expectSmallest(client::ProtocolSimulation& simulation, const client::Scenario& small,
                    const std::string& rule, std::uint64_t seed) {
  const auto breaks = [&](const client::Scenario& scenario) {
    const auto result = simulation.run(scenario, seed);
    return result.ok() && !result->violations.empty() && result->violations.front().rule == rule;
  };
  EXPECT_TRUE(breaks(small));
  for (std::size_t i = 0; i < small.faults.size(); ++i) {
    client::Scenario without = small;
    without.faults.erase(without.faults.begin() + static_cast<std::ptrdiff_t>(i));
    EXPECT_FALSE(breaks(without)) << "fault " << i << " is not needed\n" << toJson(small);
  }
  for (std::size_t site = 0; site < small.sites.size(); ++site) {
    const std::vector<nlohmann::json> steps = nlohmann::json::parse(small.sites[site].script);
    for (std::size_t i = 0; i < steps.size(); ++i) {
      std::vector<nlohmann::json> fewer = steps;
      fewer.erase(fewer.begin() + static_cast<std::ptrdiff_t>(i));
      client::Scenario without = small;
      without.sites[site].script = nlohmann::json(fewer).dump();
      EXPECT_FALSE(breaks(without)) << "step " << i << " of site " << site << "\n" << toJson(small);
    }
  }
}

TEST(ProtocolSessionsMinimised, KeepOnlyWhatThePlantedMistakeNeeds) {
  client::ProtocolSimulation simulation(protocolScene(), client::Mistake::journalForgotten);
  int found = 0;
  for (std::uint64_t seed = 1; seed < 100 && found < 2; ++seed) {
    const client::Scenario scenario = drawProtocolSession(seed);
    const auto result = simulation.run(scenario, seed);
    ASSERT_TRUE(result.ok()) << result.error().message;
    if (result->violations.empty() || scenario.faults.size() < 6) continue;
    ++found;
    const client::Scenario small = minimised(simulation, scenario, seed);
    EXPECT_LE(small.faults.size(), 2u) << toJson(small);
    EXPECT_LE(small.sites.size(), 2u) << toJson(small);
    EXPECT_LT(toJson(small).size(), toJson(scenario).size() / 4) << toJson(small);
    expectSmallest(simulation, small, result->violations.front().rule, seed);
  }
  EXPECT_EQ(found, 2);
}

INSTANTIATE_TEST_SUITE_P(Seeds, ProtocolSessions, testing::Range(0, kParts));

}  // namespace
}  // namespace tandem::test
