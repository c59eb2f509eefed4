#include "tests/simulation/protocol_draw.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <random>
#include <utility>

#include "assets/gltf/load_gltf.h"
#include "tests/support/source_file.h"

namespace tandem::test {
namespace {

using client::Fault;
using Kind = Fault::Kind;
using nlohmann::json;

constexpr double kCalm = 38.0, kEnd = 60.0;  // s
constexpr double kLastRelease = 57.0;        // s, so that all replicas come to rest

constexpr std::array<const char*, kFaultClasses> kNames{
    "serverKilled", "serverPaused",     "siteKilled", "sitePaused", "leaves",      "revokes",
    "resets",       "diskFails",        "diskSlow",   "tornWrites", "bitRot",      "lyingDisk",
    "drift",        "driftBeyondBound", "wallClock",  "observers",  "lateJoiners", "oneWayCuts",
    "blackouts",    "delayPerSite",     "delaySteps", "bursts",     "slowUplinks", "losses",
    "duplicates",   "reordering",       "malformed",  "replayed",   "escalated",   "floods",
    "forged"};

class Draw {
 public:
  Draw(std::uint64_t seed, FaultMask mask, bool every) : random_(seed * 0x9e3779b97f4a7c15ull + 11) {
    const double share = std::array{0.1, 0.25, 0.5}[below(3)];
    for (std::size_t i = 0; i < kFaultClasses; ++i)
      if (chance(share) || every) on_ |= FaultMask{1} << i;
    on_ &= mask;
  }

  client::Scenario scenario() {
    scenario_.scene = "shared_blocks.gltf";
    scenario_.duration = kEnd;
    scenario_.calmFrom = kCalm;
    scenario_.packetHz = in(10.0, 30.0);
    drawSites();
    drawNetwork();
    for (std::size_t i = 0; i < kFaultClasses; ++i)
      if (on_ >> i & 1) drawFaults(static_cast<FaultClass>(i));
    return std::move(scenario_);
  }

 private:
  double in(double low, double high) {
    return low + (high - low) * static_cast<double>(random_() >> 11) * 0x1p-53;
  }
  bool chance(double p) { return in(0.0, 1.0) < p; }
  std::size_t below(std::size_t n) { return static_cast<std::size_t>(random_() % n); }
  bool on(FaultClass faults) const { return (on_ & only(faults)) != 0; }
  std::string anySite() { return scenario_.sites[below(scenario_.sites.size())].name; }
  std::string anyPart() { return chance(0.7) ? "block" : "plate"; }
  double anyTime() { return rounded(in(1.0, kCalm - 1.0)); }
  static double rounded(double s) { return std::round(s * 1e3) * 1e-3; }

  /// Takes parts, moves them and lets go, until `until`.
  void play(json& steps, double from, double until, double pause) {
    double t = from;
    while (t < until - 1.5) {
      steps.push_back({{"t", rounded(t)}, {"do", "grasp"}, {"part", anyPart()}});
      t += in(0.1, 0.5);
      for (int moves = static_cast<int>(below(3)); moves > 0; --moves) {
        const double over = rounded(in(0.1, 0.6));
        steps.push_back(
            {{"t", rounded(t)},
             {"do", "move_relative"},
             {"by", {rounded(in(-0.02, 0.02)), rounded(in(-0.02, 0.02)), rounded(in(-0.02, 0.02))}},
             {"over_s", over}});
        t += over + in(0.0, chance(0.1) ? 4.0 : 0.4);
      }
      t = std::min(t, until - 0.1);
      steps.push_back({{"t", rounded(t)}, {"do", "release"}});
      t += in(0.05, pause);
    }
  }

  void addSite(const std::string& role) {
    client::ScenarioSite site;
    site.name = std::string(1, static_cast<char>('a' + scenario_.sites.size()));
    site.role = role;
    const bool late = on(FaultClass::lateJoiners) && !scenario_.sites.empty() && chance(0.6);
    if (late) site.joins = rounded(chance(0.3) ? in(kLastRelease - 5.0, kLastRelease + 1.0) : in(0.5, 30.0));
    json steps = json::array();
    const double begins = rounded(in(0.3, 3.0));
    play(steps, begins, kCalm, chance(0.3) ? 4.0 : 1.0);
    play(steps, rounded(kCalm + in(0.3, 3.0)), kLastRelease, 1.0);
    site.script = steps.dump();
    scenario_.sites.push_back(site);
  }

  void drawSites() {
    const bool commands = on(FaultClass::revokes) || on(FaultClass::resets);
    for (std::size_t n = 2 + below(3); n > 0; --n)
      addSite(commands && scenario_.sites.empty() ? "instructor" : "participant");
    if (on(FaultClass::observers))
      for (std::size_t n = 1 + below(2); n > 0; --n) addSite("observer");
  }

  void drawNetwork() {
    sync::NetworkConditions& network = scenario_.network;
    network.oneWay =
        static_cast<sync::Micros>(1e3 * std::round(chance(0.7) ? in(2.0, 80.0) : in(80.0, 300.0)));
    network.jitter = rounded(in(0.0, 0.5));
    if (on(FaultClass::losses)) network.loss = rounded(chance(0.5) ? 0.03 : in(0.0, 0.4));
    if (on(FaultClass::duplicates)) network.duplicate = rounded(in(0.02, 0.4));
    if (on(FaultClass::reordering)) network.reorder = rounded(in(0.02, 0.4));
  }

  /// Draws nothing but the time. What else is drawn has a statement of its own before the call: the order in
  /// which arguments are evaluated is the compiler's, and a seed means one session.
  void add(Kind kind, double lasts, const std::string& site = "", double amount = 0.0) {
    Fault fault;
    fault.kind = kind;
    fault.at = anyTime();
    fault.lasts = lasts < 0.0 ? -1.0 : rounded(lasts);
    fault.site = site;
    fault.amount = rounded(amount);
    scenario_.faults.push_back(fault);
  }

  void addToSite(Kind kind, double lasts, double amount = 0.0) { add(kind, lasts, anySite(), amount); }

  void drawFaults(FaultClass faults) {
    for (std::size_t n = 1 + below(4); n > 0; --n) drawFault(faults);
  }
  void drawFault(FaultClass faults) {
    if (faults <= FaultClass::resets) return drawDeeds(faults);
    if (faults <= FaultClass::wallClock) return drawOfServer(faults);
    if (faults <= FaultClass::reordering) return drawOfNetwork(faults);
    constexpr std::array kStrangers{Kind::malformed, Kind::replay, Kind::escalate, Kind::flood, Kind::forge};
    const auto index = static_cast<std::size_t>(faults) - static_cast<std::size_t>(FaultClass::malformed);
    add(kStrangers[index], in(0.5, faults == FaultClass::floods ? 2.0 : 6.0));
  }

  void drawDeeds(FaultClass faults) {
    switch (faults) {
      case FaultClass::serverKilled:
        return add(Kind::killServer, in(0.05, chance(0.2) ? 6.0 : 1.0), "server");
      case FaultClass::serverPaused:
        return add(Kind::pauseServer, in(0.1, 3.0), "server");
      case FaultClass::siteKilled:
        return addToSite(Kind::killSite, chance(0.3) ? -1.0 : in(0.2, 3.0));
      case FaultClass::sitePaused:
        return addToSite(Kind::pauseSite, in(0.1, 4.0));
      case FaultClass::leaves:
        if (chance(0.4)) add(Kind::leave, -1.0, anySite());
        return;
      case FaultClass::revokes:
        add(Kind::revoke, -1.0, chance(0.7) ? scenario_.sites[0].name : anySite());
        scenario_.faults.back().part = anyPart();
        return;
      default:
        add(Kind::reset, -1.0, chance(0.7) ? scenario_.sites[0].name : anySite());
        if (chance(0.5)) scenario_.faults.back().at = kLastRelease + 1.0;
        return;
    }
  }

  void drawOfServer(FaultClass faults) {
    switch (faults) {
      case FaultClass::diskFails:
        add(Kind::diskFails, in(0.1, 2.0));
        if (chance(0.7)) restartAfter(in(0.5, 4.0));
        return;
      case FaultClass::diskSlow:
        return drawDiskSlow();
      case FaultClass::tornWrites:
        add(Kind::diskTears, 10.0);
        return restartAfter(in(0.5, 4.0));
      case FaultClass::bitRot:
        add(Kind::diskRots, -1.0);
        return restartAfter(in(0.01, 3.0));
      case FaultClass::lyingDisk:
        add(Kind::diskLies, 5.0);
        return restartAfter(in(0.5, 4.0));
      case FaultClass::drift:
        return drawDrift();
      case FaultClass::driftBeyondBound: {
        const double ppm = in(-2e5, 2e5);
        return addToSite(Kind::drift, in(2.0, 10.0), ppm);
      }
      default:
        return drawWallSteps();
    }
  }

  void drawDiskSlow() {
    const double delay = in(0.01, chance(0.2) ? 2.0 : 0.2);
    add(Kind::diskSlow, in(0.5, 5.0), "", delay);
    if (chance(0.5)) restartAfter(in(0.2, 2.0));
  }

  void drawDrift() {
    const double ppm = in(-240.0, 240.0), lasts = chance(0.5) ? -1.0 : in(2.0, 20.0);
    add(Kind::drift, lasts, chance(0.3) ? "server" : anySite(), ppm);
    addBlackout(in(1.9, 4.0));  // leases lapse by it
  }

  void addBlackout(double lasts) {
    const double at = anyTime();
    scenario_.blackouts.push_back({anySite(), at, rounded(lasts)});
  }

  void drawWallSteps() {
    if (chance(0.3)) add(Kind::replay, 8.0);  // somebody is there who keeps a used token
    add(Kind::wallStep, -1.0, "", std::round(in(-1e5, 1e5)));
    if (chance(0.5)) return;
    const Fault step = scenario_.faults.back();  // and back
    add(Kind::wallStep, -1.0, "", -step.amount);
    scenario_.faults.back().at = std::min(step.at + rounded(in(1.2, 4.0)), kCalm - 0.5);
  }

  /// Kills the server within the fault that was drawn last, or soon after.
  void restartAfter(double seconds) {
    const double at = scenario_.faults.back().at + seconds;
    add(Kind::killServer, in(0.05, 1.0), "server");
    scenario_.faults.back().at = rounded(at);
  }

  void drawOfNetwork(FaultClass faults) {
    switch (faults) {
      case FaultClass::oneWayCuts: {
        const double lasts = in(0.1, 5.0);
        return addToSite(chance(0.5) ? Kind::cutUp : Kind::cutDown, lasts);
      }
      case FaultClass::blackouts:
        return addBlackout(in(0.05, 4.0));
      case FaultClass::delayPerSite: {
        if (chance(0.3)) addToSite(Kind::cutUp, in(1.9, 4.0));  // leases lapse by it
        const double delay = in(0.001, chance(0.2) ? 3.0 : 0.2);
        return addToSite(Kind::delay, chance(0.3) ? -1.0 : in(0.5, 10.0), delay);
      }
      case FaultClass::delaySteps: {
        const double at = anyTime();
        scenario_.steps.push_back({at, static_cast<sync::Micros>(1e3 * std::round(in(2.0, 400.0)))});
        return;
      }
      case FaultClass::bursts: {
        const double loss = in(0.3, 1.0), lasts = in(0.05, 3.0);
        return add(Kind::burst, lasts, chance(0.5) ? "all" : anySite(), loss);
      }
      case FaultClass::slowUplinks: {
        const double rate = std::round(in(100.0, 8000.0));
        return addToSite(Kind::uplink, in(1.0, 10.0), rate);
      }
      default:
        return;  // conditions of the whole session
    }
  }

  std::mt19937_64 random_;
  FaultMask on_ = 0;
  client::Scenario scenario_;
};

/// What the session breaks first; nothing if it keeps all rules.
std::optional<client::Violation> brokenFirst(client::ProtocolSimulation& simulation,
                                             const client::Scenario& scenario, std::uint64_t seed) {
  const Result<client::ProtocolResult> result = simulation.run(scenario, seed);
  if (!result.ok() || result->violations.empty()) return std::nullopt;
  return result->violations.front();
}

/// Leaves entries out of a scenario as long as it still breaks the same rule first.
class Minimiser {
 public:
  Minimiser(client::ProtocolSimulation& simulation, client::Scenario scenario, std::uint64_t seed)
      : simulation_(simulation), scenario_(std::move(scenario)), seed_(seed) {}

  client::Scenario run() {
    const std::optional<client::Violation> broken = brokenFirst(simulation_, scenario_, seed_);
    if (!broken) return scenario_;
    rule_ = broken->rule;
    endAfter(broken->at);
    for (std::size_t before = size() + 1; size() < before;) {
      before = size();
      shrink(scenario_.faults);
      shrink(scenario_.blackouts);
      shrink(scenario_.steps);
      for (client::ScenarioSite& site : scenario_.sites) shrinkScript(site);
      shrinkSites();
    }
    return scenario_;
  }

 private:
  bool stillBreaks() {
    const std::optional<client::Violation> broken = brokenFirst(simulation_, scenario_, seed_);
    return broken && broken->rule == rule_;
  }
  std::size_t size() const {
    std::size_t steps = 0;
    for (const client::ScenarioSite& site : scenario_.sites) steps += site.script.size();
    return scenario_.faults.size() + scenario_.blackouts.size() + scenario_.steps.size() +
           scenario_.sites.size() + steps;
  }

  /// Nothing happens after the rule is broken, unless it is judged at the end.
  void endAfter(double seconds) {
    const double before = std::exchange(scenario_.duration, std::ceil(seconds * 10.0 + 1.0) * 0.1);
    if (scenario_.duration >= before || !stillBreaks()) scenario_.duration = before;
  }

  /// Leaves out runs of entries, of half of the list first.
  template <typename List, typename Apply>
  void shrink(List& list, const Apply& apply) {
    for (std::size_t run = std::max<std::size_t>(1, list.size() / 2); run > 0; run /= 2) {
      for (std::size_t at = 0; at < list.size();) {
        const List before = list;
        const auto begin = list.begin() + static_cast<std::ptrdiff_t>(at);
        list.erase(begin, begin + static_cast<std::ptrdiff_t>(std::min(run, list.size() - at)));
        apply();
        if (stillBreaks()) continue;
        list = before;
        apply();
        at += run;
      }
    }
  }
  template <typename List>
  void shrink(List& list) {
    shrink(list, [] {});
  }

  void shrinkScript(client::ScenarioSite& site) {
    std::vector<json> steps = json::parse(site.script), kept;
    // A hand that asks for nothing gets nothing: what it asks for in the calm is what L3 is judged by.
    if (rule_ == toString(client::Rule::L3)) {
      const auto calm = std::find_if(steps.begin(), steps.end(), [&](const json& step) {
        return step.at("t").get<double>() >= scenario_.calmFrom;
      });
      kept.assign(calm, steps.end());
      steps.erase(calm, steps.end());
    }
    shrink(steps, [&] {
      std::vector<json> whole = steps;
      whole.insert(whole.end(), kept.begin(), kept.end());
      site.script = json(whole).dump();
    });
  }

  bool isNamed(const std::string& name) const {
    const auto uses = [&](const auto& entry) { return entry.site == name; };
    return std::any_of(scenario_.faults.begin(), scenario_.faults.end(), uses) ||
           std::any_of(scenario_.blackouts.begin(), scenario_.blackouts.end(), uses);
  }
  void shrinkSites() {
    for (std::size_t i = scenario_.sites.size(); i-- > 0 && scenario_.sites.size() > 1;) {
      if (isNamed(scenario_.sites[i].name)) continue;
      const std::vector<client::ScenarioSite> before = scenario_.sites;
      scenario_.sites.erase(scenario_.sites.begin() + static_cast<std::ptrdiff_t>(i));
      if (!stillBreaks()) scenario_.sites = before;
    }
  }

  client::ProtocolSimulation& simulation_;
  client::Scenario scenario_;
  const std::uint64_t seed_;
  std::string rule_;
};

}  // namespace

const char* toString(FaultClass faults) { return kNames[static_cast<std::size_t>(faults)]; }

client::Scenario drawProtocolSession(std::uint64_t seed, FaultMask mask, bool every) {
  return Draw(seed, mask, every).scenario();
}

client::Scenario minimised(client::ProtocolSimulation& simulation, const client::Scenario& scenario,
                           std::uint64_t seed) {
  return Minimiser(simulation, scenario, seed).run();
}

const assets::Scene& protocolScene() {
  static const assets::Scene scene = [] {
    const std::string path = sourceFile("tests/simulation/scenarios/shared_blocks.gltf");
    Result<assets::Scene> loaded = assets::loadGltf(path, {});
    EXPECT_TRUE(loaded.ok()) << (loaded.ok() ? "" : loaded.error().message);
    return std::move(*loaded);
  }();
  return scene;
}

}  // namespace tandem::test
