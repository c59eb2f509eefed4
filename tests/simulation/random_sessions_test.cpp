// Sessions drawn at random: who grasps which part when, the network, and the faults. Each one must keep every
// rule of ownership and create no energy, and no hand may feel what happens elsewhere. TANDEM_SEEDS sets
// their number, TANDEM_FIRST_SEED the first seed; TANDEM_TRACE names a file for the trace of the last
// session.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <random>
#include <set>

#include "tests/simulation/bounds.h"
#include "tests/simulation/shared_sessions.h"

namespace tandem::test {
namespace {

constexpr double kForce = 3.3;  // N, of a desktop arm
constexpr double kQuiet = 7.0,
                 kSessionEnd = 10.0;  // s: all hands are at rest from the first on, until the second

std::uint64_t firstSeed() {
  const char* text = std::getenv("TANDEM_FIRST_SEED");
  return text != nullptr ? std::strtoull(text, nullptr, 10) : 1;
}

/// The random numbers of one session.
class SessionDice {
 public:
  explicit SessionDice(std::uint64_t seed) : random_(seed * 0x9e3779b97f4a7c15ull + 7) {}
  double in(double low, double high) {
    return low + (high - low) * std::generate_canonical<double, 32>(random_);
  }
  bool chance(double p) { return in(0.0, 1.0) < p; }
  std::size_t below(std::size_t n) { return static_cast<std::size_t>(random_() % n); }

 private:
  std::mt19937_64 random_;
};

/// A person who takes parts, moves them and lets go, and is at rest from kQuiet on.
std::string script(SessionDice& dice) {
  nlohmann::json steps = nlohmann::json::array();
  double t = dice.in(0.3, 2.0);
  while (t < kQuiet - 1.5) {
    const char* part = dice.chance(0.75) ? "block" : "plate";
    steps.push_back({{"t", t}, {"do", "grasp"}, {"part", part}, {"over_s", 0.4}});
    t += dice.in(0.8, 1.5);
    while (t < kQuiet - 1.2 && dice.chance(0.6)) {
      const double over = dice.in(0.3, 0.8);
      steps.push_back({{"t", t},
                       {"do", "move_relative"},
                       {"by", {dice.in(-0.02, 0.02), dice.in(-0.02, 0.02), dice.in(-0.02, 0.02)}},
                       {"over_s", over}});
      t += over + dice.in(0.1, 0.8);
    }
    if (t > kQuiet - 0.5 || dice.chance(0.3)) break;  // holds on to the end
    steps.push_back({{"t", t}, {"do", "release"}});
    t += dice.in(0.2, 1.0);
  }
  return steps.dump();
}

client::Fault fault(SessionDice& dice, const std::string& site) {
  using Kind = client::Fault::Kind;
  const double at = dice.in(1.0, kQuiet - 0.5);
  switch (dice.below(3)) {
    case 0:
      return {Kind::killServer, at, dice.in(0.05, 1.0), ""};
    case 1:
      return {Kind::pauseSite, at, dice.in(0.1, 2.5), site};
    default:
      return {Kind::killSite, at, dice.chance(0.5) ? -1.0 : dice.in(0.2, 1.0), site};
  }
}

/// Draws a session into `scenario`. Returns which sites are paused or killed: their devices' watchdogs let go
/// of the hand, which therefore feels a step.
std::vector<bool> draw(client::Scenario& scenario, std::uint64_t seed) {
  SessionDice dice(seed);
  const haptics::ArmParameters arms[] = {relaxedArm(), firmArm(), lightArm()};
  const std::size_t count = 2 + dice.below(3);
  const client::ScenarioSite plain = scenario.sites[0];
  scenario.sites.assign(count, plain);
  for (std::size_t i = 0; i < count; ++i) {
    client::ScenarioSite& site = scenario.sites[i];
    site.name = std::string(1, static_cast<char>('a' + i));
    site.arm = arms[dice.below(3)];
    // A device at its limit gives the hand less force than the part receives. That creates energy, but not in
    // the links, so the limit is out of reach here.
    site.device.forceMax = 30.0;
    site.stiffness = 200.0;  // N/m: what such a device can display without limit cycles
    site.start = {dice.in(-0.03, 0.03), dice.in(-0.08, 0.02), 0.09};
    site.joins = dice.chance(0.2) ? dice.in(0.0, 3.0) : 0.0;
    site.script = script(dice);
  }
  scenario.duration = kSessionEnd;
  scenario.network.oneWay = static_cast<sync::Micros>(1e3 * dice.in(2.0, 200.0));
  scenario.network.jitter = dice.in(0.0, 0.5);
  scenario.network.loss = dice.chance(0.5) ? 0.02 : dice.in(0.0, 0.3);
  scenario.network.duplicate = dice.chance(0.5) ? 0.0 : dice.in(0.0, 0.3);
  scenario.network.reorder = dice.chance(0.5) ? 0.0 : dice.in(0.0, 0.3);
  std::vector<bool> disturbed(count, false);
  for (std::size_t n = dice.below(3); n > 0; --n) {
    const std::size_t site = dice.below(count);
    scenario.faults.push_back(fault(dice, scenario.sites[site].name));
    if (scenario.faults.back().kind != client::Fault::Kind::killServer) disturbed[site] = true;
  }
  if (dice.chance(0.4)) {
    scenario.blackouts.push_back(
        {scenario.sites[dice.below(count)].name, dice.in(1.0, kQuiet - 1.0), dice.in(0.05, 1.5)});
  }
  if (dice.chance(0.3)) {
    scenario.steps.push_back(
        {dice.in(1.0, kQuiet - 0.5), static_cast<sync::Micros>(1e3 * dice.in(2.0, 250.0))});
  }
  return disturbed;
}

struct Tally {
  double shared = 0.0;  // s
  std::size_t grants = 0, restarts = 0, deaths = 0, pauses = 0, pushed = 0, unpushed = 0, gentle = 0,
              rough = 0;
};

void check(SharedSession& session, const client::Scenario& plain, std::uint64_t seed, Tally& tally) {
  session.scenario = plain;
  const std::vector<bool> disturbed = draw(session.scenario, seed);
  session.options.seed = seed;
  if (const char* path = std::getenv("TANDEM_TRACE")) session.options.tracePath = path;
  const client::SimulationResult result = session.run();
  SCOPED_TRACE("TANDEM_FIRST_SEED=" + std::to_string(seed) + " TANDEM_SEEDS=1");
  EXPECT_TRUE(result.violations.empty()) << describe(result);
  EXPECT_LE(result.energyOfLinks, kEnergyBound);
  // Where a hand feels more than a desktop device can give, its force falls faster after a release, too.
  const bool gentle = std::all_of(result.sites.begin(), result.sites.end(),
                                  [](const auto& site) { return site.second.maxForce < kForce; });
  ++(gentle ? tally.gentle : tally.rough);
  for (std::size_t i = 0; i < disturbed.size(); ++i) {
    const client::SimulatedSiteResult& site = result.sites.at(session.scenario.sites[i].name);
    // The work that others do on a bare tool by pushing a part against it is known only roughly, from the
    // contact forces and the motion of the part.
    EXPECT_TRUE(site.pushed || site.energyCreated <= kEnergyBound)
        << session.scenario.sites[i].name << " " << site.energyCreated;
    ++(site.pushed ? tally.pushed : tally.unpushed);
    EXPECT_TRUE(site.calm || disturbed[i] || !gentle)
        << session.scenario.sites[i].name << " felt something while all stood still";
  }
  tally.shared += result.shared;
  tally.grants += result.grants.size();
  for (const client::Fault& f : session.scenario.faults) {
    tally.restarts += f.kind == client::Fault::Kind::killServer ? 1 : 0;
    tally.deaths += f.kind == client::Fault::Kind::killSite ? 1 : 0;
    tally.pauses += f.kind == client::Fault::Kind::pauseSite ? 1 : 0;
  }
}

constexpr int kShares = 4;  // test cases, which can run side by side

class RandomSessions : public testing::TestWithParam<int> {};

TEST_P(RandomSessions, KeepEveryRuleAndHurtNoHand) {
  SharedSession session("shared_pull", SharedSession::Contact::none);
  const client::Scenario plain = session.scenario;
  Tally tally;
  for (std::uint64_t i = static_cast<std::uint64_t>(GetParam()); i < sessions(); i += kShares)
    check(session, plain, firstSeed() + i, tally);
  std::printf("shared for %.0f s, %zu grants, %zu restarts of the server, %zu sites died, %zu paused\n",
              tally.shared, tally.grants, tally.restarts, tally.deaths, tally.pauses);
  if (sessions() < 100) return;
  EXPECT_GT(tally.shared, 0.5 * static_cast<double>(sessions() / kShares))
      << "too little is shared to tell anything";
  EXPECT_GT(tally.unpushed, tally.pushed);
  EXPECT_GT(tally.gentle, tally.rough);
  EXPECT_GT(std::min({tally.grants, tally.restarts, tally.deaths, tally.pauses}), sessions() / kShares / 10);
}

/// The rules that a mistake breaks within the first 60 sessions, up to the session that breaks `awaited`.
std::set<std::string> rulesBrokenBy(client::Mistake mistake, const std::string& awaited = "") {
  SharedSession session("shared_pull", SharedSession::Contact::none);
  const client::Scenario plain = session.scenario;
  session.options.mistake = mistake;
  std::set<std::string> rules;
  for (session.options.seed = 1; session.options.seed <= 60 && !rules.contains(awaited);
       ++session.options.seed) {
    session.scenario = plain;
    draw(session.scenario, session.options.seed);
    for (const client::Violation& violation : session.run().violations) rules.insert(violation.rule);
  }
  return rules;
}

TEST(RandomSessionsControl, ServerThatForgetsItsEpochsIsCaught) {
  EXPECT_TRUE(rulesBrokenBy(client::Mistake::none).empty());
  EXPECT_TRUE(rulesBrokenBy(client::Mistake::journalForgotten, "S1").contains("S1"));
}

TEST(RandomSessionsControl, ServerThatRegrantsEarlyIsCaught) {
  EXPECT_TRUE(rulesBrokenBy(client::Mistake::regrantedEarly, "S3").contains("S3"));
}

TEST(RandomSessionsControl, SitesThatDoubtAtOnceNameHonestOnes) {
  EXPECT_TRUE(rulesBrokenBy(client::Mistake::doubtsAtOnce, "R5").contains("R5"));
}

INSTANTIATE_TEST_SUITE_P(Seeds, RandomSessions, testing::Range(0, kShares));

}  // namespace
}  // namespace tandem::test
