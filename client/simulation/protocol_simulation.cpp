#include "client/simulation/protocol_simulation.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>

#include <glm/geometric.hpp>

#include "assets/base/assert.h"
#include "assets/base/json.h"
#include "client/simulation/fault_schedule.h"
#include "client/simulation/fingerprint.h"
#include "client/simulation/light_site.h"
#include "client/simulation/scenario_scripts.h"

namespace tandem::client {

using namespace sync;

namespace {

constexpr Micros kNever = Micros{1} << 55;
/// L3: each hand that goes on asking gets a part so often, once all is calm and the sessions stand again.
constexpr Micros kSettling = 8 * kSecond;
/// L3: up to this way between sites, s, hands share a part whatever jitter was measured before all was calm;
/// beyond 150 ms a part has one holder at a time. And the turns of programs and disk that requests wait for.
constexpr double kSharedWay = 0.1, kTurns = 0.3;

/// For how long a hand asks for a part or holds it, s.
struct Ask {
  PartId part = kNoPart;
  double from = 0.0, until = 0.0;
};

std::vector<Ask> asksOf(const std::vector<ScriptStep>& script) {
  std::vector<Ask> asks;
  bool asking = false;
  for (const ScriptStep& step : script) {
    if (step.verb == ScriptStep::Verb::grasp && !asking) asks.push_back({step.part, step.at, 1e9});
    if (step.verb == ScriptStep::Verb::release && asking) asks.back().until = step.at;
    if (step.verb == ScriptStep::Verb::grasp) asking = true;
    if (step.verb == ScriptStep::Verb::release) asking = false;
  }
  return asks;
}

}  // namespace

class ProtocolSimulation::Run {
 public:
  Run(const Scenario& scenario, const assets::Scene& scene, std::uint64_t seed, Mistake mistake)
      : scenario_(scenario),
        scene_(scene),
        network_(seed, scenario.network),
        invariants_(scenario.sites.size(), LeaseRules{}),
        server_(scene, network_, seed, mistake),
        faults_(scenario, scene, network_, server_, invariants_, seed),
        end_(static_cast<Micros>(std::llround(scenario.duration * 1e3)) * kMillisecond),
        settledAt_(static_cast<Micros>(scenario.calmFrom * 1e6) + kSettling) {}

  Status addSites(ExchangePool& pool, std::uint64_t seed);
  void run();
  ProtocolResult result();

 private:
  Micros nextInstant() const;
  void step();
  void judgeLiveness();
  bool mustBeServed(std::size_t site) const;
  double replicaError(PartId part) const;

  const Scenario& scenario_;
  const assets::Scene& scene_;
  VirtualNetwork network_;
  Invariants invariants_;
  SimulatedServer server_;
  FaultSchedule faults_;
  std::vector<std::unique_ptr<LightSite>> sites_;
  Micros now_ = 0, end_, serverDue_ = 0;
  Micros settledAt_;
  bool settled_ = false;
  std::uint64_t steps_ = 0, serverSteps_ = 0, siteSteps_ = 0;
};

Status ProtocolSimulation::Run::addSites(ExchangePool& pool, std::uint64_t seed) {
  Result<std::vector<HandScript>> scripts = parseScripts(scenario_, scene_);
  if (!scripts) return scripts.error();
  std::mt19937_64 random(seed * 0x9e3779b97f4a7c15ull + 1);
  for (std::size_t i = 0; i < scenario_.sites.size(); ++i) {
    const ScenarioSite& description = scenario_.sites[i];
    const auto offset = static_cast<Micros>(random() % 1000000000000ull);
    sites_.push_back(
        std::make_unique<LightSite>(LightWorld{scenario_, scene_, network_, server_, invariants_}, pool, i,
                                    description, std::move((*scripts)[i]), offset));
    faults_.addSite(*sites_.back());
  }
  return {};
}

/// The next millisecond in which something is due.
Micros ProtocolSimulation::Run::nextInstant() const {
  Micros next = std::min(faults_.nextDue(kNever), network_.nextArrival().value_or(kNever));
  if (server_.running()) next = std::min(next, serverDue_);
  for (const auto& site : sites_) next = std::min(next, site->nextDue());
  next = std::max(next, now_ + 1);
  return (next + kMillisecond - 1) / kMillisecond * kMillisecond;
}

void ProtocolSimulation::Run::step() {
  ++steps_;
  invariants_.setTime(now_);
  network_.advanceTo(now_);
  server_.journal().advanceTo(now_);
  const bool ran = server_.running();
  faults_.advanceTo(now_);
  if (server_.running() && (!ran || now_ >= serverDue_ || (server_.hasEvents() && !server_.paused(now_)))) {
    ++serverSteps_;
    server_.step(now_, invariants_);
    serverDue_ = server_.nextStep(now_);
  }
  for (auto& site : sites_) {
    if (now_ < site->nextDue() && !site->hasEvents(now_)) continue;
    ++siteSteps_;
    site->step(now_);
  }
}

void ProtocolSimulation::Run::run() {
  server_.start(0, invariants_);
  const bool judges = scenario_.calmFrom >= 0.0;
  for (step(); now_ < end_; step()) {
    now_ = std::min(nextInstant(), end_);
    if (!judges || settled_ || now_ < settledAt_) continue;
    settled_ = true;
    for (auto& site : sites_) static_cast<void>(site->drainGranted());
  }
}

/// Whether the hand has asked, since all is calm, for longer than two round trips; and where parts are not
/// shared, for a part that nobody else wanted then.
bool ProtocolSimulation::Run::mustBeServed(std::size_t site) const {
  const double way = toSeconds(scenario_.network.oneWay), settled = toSeconds(settledAt_);
  for (const Ask& ask : asksOf(sites_[site]->script())) {
    const double asked = std::min(ask.until, scenario_.duration) - ask.from;
    if (ask.from < settled || asked < 2.0 * way + kTurns) continue;
    bool contested = false;
    for (std::size_t other = 0; other < sites_.size() && way > kSharedWay; ++other)
      for (const Ask& rival : asksOf(sites_[other]->script()))
        contested = contested || (other != site && rival.part == ask.part &&
                                  rival.from < ask.from + way + kTurns &&
                                  rival.until > ask.from - 2.0 * way - kTurns);
    if (!contested) return true;
  }
  return false;
}

/// What must hold at the end of a session that was calm for long enough.
void ProtocolSimulation::Run::judgeLiveness() {
  if (!settled_) return;
  for (std::size_t i = 0; i < sites_.size(); ++i) {
    LightSite& site = *sites_[i];
    if (!site.takesPart()) continue;
    invariants_.checked(Rule::L4);
    if (!site.inSession()) {
      invariants_.reportBroken(Rule::L4, site.name() + " is not in the session, though nothing keeps it out");
      continue;
    }
    const bool late = scenario_.sites[i].joins * 1e6 > static_cast<double>(settledAt_);
    if (scenario_.sites[i].role == "observer" || late || !mustBeServed(i)) continue;
    invariants_.checked(Rule::L3);
    if (site.drainGranted() == 0)
      invariants_.reportBroken(Rule::L3, site.name() + " got no part since all is calm");
  }
}

/// By how much the poses of a part that nobody owns differ between the sites, and from the server's, m.
double ProtocolSimulation::Run::replicaError(PartId part) const {
  const LightSite* first = nullptr;
  double error = 0.0;
  const PartRecord* record =
      server_.session() != nullptr ? &server_.session()->ownership().part(part) : nullptr;
  for (const auto& site : sites_) {
    if (!site->inSession() || site->ownerOf(part) != kNoSite) continue;
    if (record != nullptr && record->owner == kNoSite)
      error =
          std::max(error, glm::length(site->worldFromPart(part).position - record->worldFromPart.position));
    if (first != nullptr)
      error = std::max(error,
                       glm::length(site->worldFromPart(part).position - first->worldFromPart(part).position));
    else
      first = site.get();
  }
  return error;
}

ProtocolResult ProtocolSimulation::Run::result() {
  judgeLiveness();
  std::vector<std::pair<std::string, double>> errors;
  for (std::size_t part = 0; part < scene_.parts.size(); ++part)
    errors.emplace_back(scene_.parts[part].name, replicaError(static_cast<PartId>(part)));
  invariants_.finish(errors);
  ProtocolResult result;
  result.violations = invariants_.violations();
  result.checks = invariants_.checks();
  result.grants = invariants_.grants();
  if (server_.session() != nullptr) result.server = server_.session()->counters();
  result.steps = steps_;
  result.serverSteps = serverSteps_;
  result.siteSteps = siteSteps_;
  Fnv1a hash;
  for (const Invariants::Grant& grant : result.grants)
    hash.addComponents(glm::dvec3(grant.at, grant.part * 65536.0 + grant.site, grant.epoch));
  for (const auto& site : sites_) {
    result.granted += site->granted();
    if (!site->inSession()) continue;
    const ConnectionStatistics statistics = site->statistics();
    result.reconnects += statistics.reconnects;
    result.droppedStates += statistics.droppedStates;
    result.malformed += statistics.malformed;
    for (std::size_t part = 0; part < scene_.parts.size(); ++part)
      hash.addComponents(site->worldFromPart(static_cast<PartId>(part)).position);
  }
  char text[17];
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(hash.value()));
  result.hash = text;
  return result;
}

ProtocolSimulation::ProtocolSimulation(const assets::Scene& scene, Mistake mistake)
    : scene_(scene), mistake_(mistake), pool_(std::make_unique<ExchangePool>()) {}
ProtocolSimulation::~ProtocolSimulation() = default;

Result<ProtocolResult> ProtocolSimulation::run(const Scenario& scenario, std::uint64_t seed) {
  ASSERT(!scenario.sites.empty() && scenario.duration > 0.0);
  Run run(scenario, scene_, seed, mistake_);
  if (Status status = run.addSites(*pool_, seed); !status) return status.error();
  run.run();
  return run.result();
}

}  // namespace tandem::client
