// A planted mistake must be found by sessions in which nothing goes wrong but what its class of faults draws.
// mutants.py builds this program with the mistakes, names one by TANDEM_MUTANT, and its class by
// TANDEM_FAULTS.

#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>

#include "tests/simulation/protocol_draw.h"

namespace tandem::test {
namespace {

/// How many sessions may pass before one finds the mistake: TANDEM_PROTOCOL_SEEDS, or 10,000.
std::uint64_t maxSeeds() {
  const char* text = std::getenv("TANDEM_PROTOCOL_SEEDS");
  return text != nullptr ? std::strtoull(text, nullptr, 10) : 10000;
}

TEST(ProtocolMutant, IsFound) {
  const char* name = std::getenv("TANDEM_FAULTS");
  if (name == nullptr) GTEST_SKIP() << "run by tests/simulation/mutants.py";
  FaultMask mask = 0;
  for (std::size_t i = 0; i < kFaultClasses; ++i)
    if (std::string(toString(static_cast<FaultClass>(i))) == name) mask = only(static_cast<FaultClass>(i));
  ASSERT_NE(mask, 0u) << "no class of faults is named " << name;
  client::ProtocolSimulation simulation(protocolScene());
  const char* text = std::getenv("TANDEM_FIRST_SEED");
  const std::uint64_t first = text != nullptr ? std::strtoull(text, nullptr, 10) : 1;
  for (std::uint64_t seed = first; seed < first + maxSeeds(); ++seed) {
    std::printf("seed %lu\n", static_cast<unsigned long>(seed));
    std::fflush(stdout);  // an assertion that finds the mistake ends the program
    const auto result = simulation.run(drawProtocolSession(seed, mask, true), seed);
    ASSERT_TRUE(result.ok()) << result.error().message;
    if (result->violations.empty()) continue;
    const client::Violation& broken = result->violations.front();
    std::printf("found by seed %lu: %s at %.3f s: %s\n", static_cast<unsigned long>(seed),
                broken.rule.c_str(), broken.at, broken.what.c_str());
    return;
  }
  FAIL() << "not found in " << maxSeeds() << " sessions";
}

}  // namespace
}  // namespace tandem::test
