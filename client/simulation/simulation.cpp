#include "client/simulation/simulation.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>

#include <glm/geometric.hpp>

#include "assets/base/assert.h"
#include "client/simulation/created_energy.h"
#include "client/simulation/scenario_scripts.h"
#include "client/simulation/simulated_site.h"

namespace tandem::client {

using namespace sync;

namespace {

/// Distances between two poses of one part, m.
struct Distances {
  double squares = 0.0, max = 0.0;
  std::uint64_t count = 0;
  void add(double distance) {
    squares += distance * distance;
    max = std::max(max, distance);
    ++count;
  }
  double rms() const { return count > 0 ? std::sqrt(squares / static_cast<double>(count)) : 0.0; }
};

class Simulation {
 public:
  Simulation(const Scenario& scenario, const haptics::ContactScene& contact, const SimulationOptions& options)
      : scenario_(scenario),
        scene_(contact.scene()),
        context_(scenario, contact, options),
        faults_(scenario, scene_, context_.network, context_.server, context_.invariants, options.seed),
        watch_(options.watch),
        created_(scenario.sites.size()),
        given_(scenario.sites.size(), 0.0) {
    if (options.tracePath.empty()) return;
    context_.trace.open(options.tracePath);
    context_.trace << "t,site,hx,hy,hz,px,py,pz,fx,fy,fz,held,flags,links,fade,play_out_ms,lx,ly,lz\n";
  }

  Status addSites(std::uint64_t seed);
  void run();
  SimulationResult result();
  /// False if the trace could not be written so far.
  bool traceIsGood() { return context_.trace.flush().good(); }

 private:
  void tick();
  void compareReplicas();
  void compareReplicas(const SimulatedSite& owner, const haptics::OwnedPart& part);
  void noteEnergy();
  void showSites();
  double replicaError(PartId part, SimulationResult& result) const;

  const Scenario& scenario_;
  const assets::Scene& scene_;
  SimulationContext context_;
  FaultSchedule faults_;
  std::function<void(double, std::span<const SimulatedSiteState>)> watch_;
  std::vector<std::unique_ptr<SimulatedSite>> sites_;
  Micros now_ = 0;
  std::vector<bool> allStill_, undisturbed_;  // a tick each
  Distances displayed_, shared_;
  std::uint64_t sharedTicks_ = 0;
  double maxLinkWork_ = 0.0;  // J
  CreatedEnergy created_;
  std::vector<double> given_;  // J, a site each
};

Status Simulation::addSites(std::uint64_t seed) {
  Result<std::vector<HandScript>> scripts = parseScripts(scenario_, scene_);
  if (!scripts) return scripts.error();
  std::mt19937_64 random(seed * 0x9e3779b97f4a7c15ull + 1);
  for (std::size_t i = 0; i < scenario_.sites.size(); ++i) {
    const ScenarioSite& description = scenario_.sites[i];
    const Pose start =
        description.hasStart ? Pose{description.start, {1.0, 0.0, 0.0, 0.0}} : defaultHandStart(scene_, i);
    // Each site's clock started some time in the last eleven days.
    const auto offset = static_cast<Micros>(random() % 1000000000000ull);
    sites_.push_back(
        std::make_unique<SimulatedSite>(context_, i, description, std::move((*scripts)[i]), start, offset));
    faults_.addSite(*sites_.back());
  }
  return {};
}

/// Measures how far the owner's pose of each part is from what the other sites draw of it at this instant,
/// and from the replicas of its co-holders.
void Simulation::compareReplicas() {
  maxLinkWork_ = std::max(maxLinkWork_, context_.linkWork);
  const Distances before = shared_;
  for (const auto& site : sites_) {
    if (!site->inSession()) continue;
    const haptics::TickOutput& tick = site->tick();
    for (int i = 0; i < tick.ownedCount; ++i) {
      const haptics::OwnedPart& part = tick.owned[static_cast<std::size_t>(i)];
      context_.fingerprint.add(part.worldFromPart.position);
      if (site->ownerOf(part.part) == site->id()) compareReplicas(*site, part);
    }
  }
  sharedTicks_ += shared_.count > before.count ? 1 : 0;
}

void Simulation::compareReplicas(const SimulatedSite& owner, const haptics::OwnedPart& part) {
  const glm::dvec3& position = part.worldFromPart.position;
  for (const auto& other : sites_) {
    if (other.get() == &owner || !other->inSession()) continue;
    displayed_.add(glm::length(other->worldFromDrawn(part.part).position - position));
    if (other->tick().simulated(part.part) == nullptr) continue;
    shared_.add(glm::length(other->worldFromPart(part.part).position - position));
  }
}

/// Sites that simulate one part act on each other from then on.
void Simulation::noteEnergy() {
  for (std::size_t i = 0; i < sites_.size(); ++i) {
    given_[i] = sites_[i]->measures().samples().back().energyGiven;
    const haptics::TickOutput& tick = sites_[i]->tick();
    for (int k = 0; k < tick.ownedCount; ++k) {
      const PartId part = tick.owned[static_cast<std::size_t>(k)].part;
      for (std::size_t other = 0; other < i; ++other)
        if (sites_[other]->tick().simulated(part) != nullptr) created_.couple(other, i);
    }
  }
  created_.add(given_);
}

void Simulation::showSites() {
  std::vector<SimulatedSiteState> states;
  for (const auto& site : sites_) {
    const HandSample& sample = site->measures().samples().back();
    states.push_back({sample.position, sample.force, &site->tick()});
  }
  watch_(toSeconds(now_), states);
}

void Simulation::tick() {
  context_.invariants.setTime(now_);
  context_.network.advanceTo(now_);
  context_.server.journal().advanceTo(now_);
  faults_.advanceTo(now_);
  context_.server.step(now_, context_.invariants);
  bool still = true, slidOff = false;
  for (auto& site : sites_) {
    if (context_.server.running()) site->startWhenDue(now_);
    site->step(now_);
    still = still && site->measures().samples().back().still;
    slidOff = slidOff || site->measures().slidOff();
  }
  ASSERT(allStill_.size() == undisturbed_.size());
  allStill_.push_back(still);
  undisturbed_.push_back(still && !slidOff);
  compareReplicas();
  noteEnergy();
  if (watch_) showSites();
}

void Simulation::run() {
  ASSERT(sites_.size() == scenario_.sites.size() && allStill_.empty());
  context_.server.start(0, context_.invariants);
  const auto ticks = static_cast<Micros>(std::llround(scenario_.duration * 1e3));
  for (Micros i = 0; i < ticks; ++i) {
    now_ = i * kSimulationTick;
    tick();
  }
}

/// By how much the poses of a part that nobody owns differ between the sites, m. The first site's pose goes
/// into the result.
double Simulation::replicaError(PartId part, SimulationResult& result) const {
  const SimulatedSite* first = nullptr;
  double error = 0.0;
  for (const auto& site : sites_) {
    if (!site->inSession() || site->ownerOf(part) != kNoSite) continue;
    const Pose& pose = site->worldFromPart(part);
    if (first != nullptr) {
      error = std::max(error, glm::length(pose.position - first->worldFromPart(part).position));
    } else {
      result.finalPoses[scene_.parts[part].name] = pose;
      first = site.get();
    }
  }
  return error;
}

SimulationResult Simulation::result() {
  SimulationResult result;
  std::vector<std::pair<std::string, double>> replicaErrors;
  for (std::size_t part = 0; part < scene_.parts.size(); ++part)
    if (context_.everOwned[part])
      replicaErrors.emplace_back(scene_.parts[part].name, replicaError(static_cast<PartId>(part), result));
  context_.invariants.finish(replicaErrors);
  for (const auto& site : sites_) {
    SimulatedSiteResult& of = result.sites[site->name()];
    of = site->result(scenario_.duration, undisturbed_);
    of.energyCreated = created_.byHand()[site->index()];
    result.energyCreated += of.energyCreated;
    result.stable = result.stable && site->measures().stable(allStill_);
    result.siteNames[site->id()] = site->name();
    result.droppedStates += site->droppedStates();
    result.denials += site->denials();
  }
  result.displayedRms = displayed_.rms();
  result.displayedMax = displayed_.max;
  result.discrepancyRms = shared_.rms();
  result.discrepancyMax = shared_.max;
  result.shared = toSeconds(static_cast<Micros>(sharedTicks_) * kSimulationTick);
  result.energyOfLinks = maxLinkWork_;
  result.grants = context_.invariants.grants();
  result.violations = context_.invariants.violations();
  for (const assets::Part& part : scene_.parts) result.partNames.push_back(part.name);
  result.hash = context_.fingerprint.hex();
  return result;
}

/// The site that owned a part first, or the first of the scenario.
std::string leader(const SimulationResult& result, const Scenario& scenario) {
  if (!result.grants.empty()) {
    const auto name = result.siteNames.find(result.grants.front().site);
    if (name != result.siteNames.end()) return name->second;
  }
  return scenario.sites.front().name;
}

}  // namespace

Result<SimulationResult> simulate(const Scenario& scenario, const haptics::ContactScene& contact,
                                  const SimulationOptions& options) {
  ASSERT(!scenario.sites.empty() && scenario.duration > 0.0);
  Simulation simulation(scenario, contact, options);
  if (Status status = simulation.addSites(options.seed); !status) return status.error();
  const Error unwritable{options.tracePath + ": cannot be written"};
  if (!simulation.traceIsGood()) return unwritable;
  simulation.run();
  if (!simulation.traceIsGood()) return unwritable;
  SimulationResult result = simulation.result();
  if (!options.leaderLoad || scenario.network.oneWay == 0) return result;
  Scenario near = scenario;
  near.network = {};
  near.steps.clear();
  SimulationOptions again = options;
  again.leaderLoad = false;
  again.tracePath.clear();
  again.watch = nullptr;
  Result<SimulationResult> reference = simulate(near, contact, again);
  if (!reference) return reference.error();
  const std::string name = leader(result, scenario);
  const double load = reference->sites[name].rmsForce;
  result.leaderLoadRatio = load > 1e-9 ? result.sites[name].rmsForce / load : 1.0;
  return result;
}

}  // namespace tandem::client
