// Sessions of the protocol alone, drawn at random with all that can go wrong. Each must keep every rule while
// things go wrong, and serve everybody once all is calm. TANDEM_PROTOCOL_SEEDS sets their number,
// TANDEM_FIRST_SEED the first seed.

#include <gtest/gtest.h>

#include <cstdlib>

#include "tests/simulation/protocol_draw.h"

namespace tandem::test {
namespace {

std::uint64_t number(const char* variable, std::uint64_t fallback) {
  const char* text = std::getenv(variable);
  return text != nullptr ? std::strtoull(text, nullptr, 10) : fallback;
}

std::string describe(const client::ProtocolResult& result) {
  std::string text;
  for (const client::Violation& violation : result.violations)
    text += violation.rule + " at " + std::to_string(violation.at) + " s: " + violation.what + "\n";
  return text;
}

constexpr int kParts = 4;  // test cases, which can run side by side

class ProtocolSessions : public testing::TestWithParam<int> {};

TEST_P(ProtocolSessions, KeepEveryRuleAndServeEverybodyInTheEnd) {
  client::ProtocolSimulation simulation(protocolScene());
  const std::uint64_t first = number("TANDEM_FIRST_SEED", 1), count = number("TANDEM_PROTOCOL_SEEDS", 200);
  std::array<std::uint64_t, client::kRules> checks{};
  std::uint64_t steps = 0, serverSteps = 0, siteSteps = 0, grants = 0, failed = 0;
  for (std::uint64_t i = static_cast<std::uint64_t>(GetParam()); i < count && failed < 5; i += kParts) {
    const client::Scenario scenario = drawProtocolSession(first + i);
    const Result<client::ProtocolResult> result = simulation.run(scenario, first + i);
    ASSERT_TRUE(result.ok()) << result.error().message;
    for (std::size_t rule = 0; rule < checks.size(); ++rule) checks[rule] += result->checks[rule];
    steps += result->steps;
    serverSteps += result->serverSteps;
    siteSteps += result->siteSteps;
    grants += result->grants.size();
    if (result->violations.empty()) continue;
    ++failed;
    const client::Scenario small = minimised(simulation, scenario, first + i);
    ADD_FAILURE() << "TANDEM_FIRST_SEED=" << first + i << " TANDEM_PROTOCOL_SEEDS=1\n"
                  << describe(*result) << "the session:\n"
                  << toJson(scenario) << "\nthe smallest that breaks a rule with --seed " << first + i
                  << ":\n"
                  << toJson(small) << "\n"
                  << describe(*simulation.run(small, first + i));
  }
  std::printf("%lu instants, %lu server steps, %lu site steps, %lu grants;", steps, serverSteps, siteSteps,
              grants);
  for (std::size_t rule = 0; rule < checks.size(); ++rule)
    std::printf(" %s %lu", toString(static_cast<client::Rule>(rule)), checks[rule]);
  std::printf("\n");
}

INSTANTIATE_TEST_SUITE_P(Seeds, ProtocolSessions, testing::Range(0, kParts));

}  // namespace
}  // namespace tandem::test
