// One hand turns a part quickly that another one holds still. No device here gives torque, so neither hand
// feels how hard they twist: their grips limit it (held_part.cpp), and neither is doubted for it.

#include <gtest/gtest.h>

#include <cstdio>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "tests/simulation/shared_sessions.h"
#include "tests/support/full_size.h"
#include "tests/support/source_file.h"

namespace tandem::test {
namespace {

std::string textOf(const std::string& path) {
  std::ifstream file(sourceFile(path));
  return {std::istreambuf_iterator<char>(file), {}};
}

TEST(TurningHands, OfTheDemoAreNotDoubted) {
  for (const double delay : {0.1, 1.0, 25.0}) {
    SharedSession session("demo", SharedSession::Contact::none);
    session.scenario.sites[0].script = textOf("client/demo_hands/ada.json");
    session.scenario.sites[1].script = textOf("client/demo_hands/ben.json");
    session.setDelay(delay);
    const client::SimulationResult result = session.run();
    EXPECT_TRUE(result.violations.empty()) << delay << " ms\n" << describe(result);
    EXPECT_LE(result.energyCreated, 1e-3) << delay << " ms";
  }
}

struct Turn {
  const char* part = "cover";
  double delay = 25.0;  // ms
  const char* axis = "x";
  double over = 0.8;  // s, for 1.2 rad
};

client::SimulationResult turned(const Turn& turn, client::Mistake mistake = client::Mistake::none) {
  SharedSession session("shared_turn", SharedSession::Contact::none);
  session.setDelay(turn.delay);
  session.options.mistake = mistake;
  for (client::ScenarioSite& site : session.scenario.sites) {
    nlohmann::json script = nlohmann::json::parse(site.script);
    script[0]["part"] = turn.part;
    if (site.name == "a") script.back().update({{"axis", turn.axis}, {"over_s", turn.over}});
    site.script = script.dump();
  }
  client::SimulationResult result = session.run();
  if (atFullSize())
    std::printf(
        "%-9s %5.1f ms, about %s in %.1f s: %.2f N in 20 ms, %.2f mJ, %.1f mm, shared %.1f s, %zu broken "
        "rules\n",
        turn.part, turn.delay, turn.axis, turn.over, result.sites.at("b").forceStep20ms,
        1e3 * result.energyCreated, 1e3 * result.discrepancyMax, result.shared, result.violations.size());
  return result;
}

/// Large and small parts, slowly and with a flick of the wrist.
std::vector<Turn> turns() {
  std::vector<Turn> all;
  for (const char* part : {"cover", "impeller", "shaft", "impeller_nut", "bolt_1"}) {
    for (const double delay : {0.1, 10.0, 50.0, 100.0}) {
      for (const char* axis : {"x", "y", "z"}) {
        for (const double over : {0.8, 0.2})
          if (atFullSize() || (over == 0.2 && (delay == 0.1 || delay == 50.0)))
            all.push_back({part, delay, axis, over});
      }
    }
  }
  return all;
}

TEST(TurningHands, AreNotDoubted) {
  for (const Turn& turn : turns()) {
    const client::SimulationResult result = turned(turn);
    EXPECT_GT(result.shared, 4.0) << turn.part;
    EXPECT_TRUE(result.violations.empty()) << turn.part << ", " << turn.delay << " ms\n" << describe(result);
    EXPECT_LE(result.energyCreated, 1e-3) << turn.part << ", " << turn.delay << " ms";
  }
}

// A hand that turns as hard as its grip's spring can, which it does not feel, is taken for a liar.
TEST(TurningHands, AreDoubtedWhereNothingLimitsHowHardTheyTurn) {
  const client::SimulationResult result = turned({"shaft", 10.0, "x", 0.2}, client::Mistake::torqueUnknown);
  ASSERT_FALSE(result.violations.empty());
  EXPECT_EQ(result.violations[0].rule, "R5") << describe(result);
}

}  // namespace
}  // namespace tandem::test
