#include "client/simulation/simulation.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <memory>
#include <random>

#include <glm/geometric.hpp>

#include "assets/scene/scene_package.h"
#include "client/hand/hand_loop.h"
#include "client/hand/scripted_device.h"
#include "client/session/server_connection.h"
#include "client/simulation/measures.h"
#include "haptics/safety/device_defaults.h"
#include "server/memory_journal.h"
#include "server/session.h"

namespace tandem::client {

using namespace sync;

namespace {

constexpr Micros kTick = kMillisecond;
constexpr std::int64_t kWallClock = 1700000000;  // Unix time at virtual time 0: any constant

/// FNV-1a over the bits of doubles: equal only if every tick was equal.
class Fingerprint {
 public:
  void add(double value) {
    std::uint64_t bits;
    std::memcpy(&bits, &value, sizeof bits);
    for (int i = 0; i < 8; ++i) {
      hash_ ^= (bits >> (8 * i)) & 0xff;
      hash_ *= 1099511628211ull;
    }
  }
  void add(const glm::dvec3& v) { add(v.x), add(v.y), add(v.z); }
  std::string hex() const {
    char text[17];
    std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(hash_));
    return text;
  }

 private:
  std::uint64_t hash_ = 14695981039346656037ull;
};

Role roleOf(const std::string& name) {
  return name == "instructor" ? Role::instructor : name == "observer" ? Role::observer : Role::participant;
}

class Simulation;

/// One person with everything at their site.
class SimulatedSite : public ConnectionObserver {
 public:
  SimulatedSite(Simulation& simulation, std::size_t index, const ScenarioSite& description, HandScript script,
                const haptics::ContactScene& contact, const Pose& start, Micros clockOffset);

  void start();
  void crash();
  void step(Micros now);

  void onOwnership(const PartRecord& record) override;
  void onGrab(const Grab& grab) override;
  void onGrabReply(const GrabReply& reply) override;
  void onRelease(const Release& release) override;
  void onAccepted(SiteId from, const PartState& state) override;
  void onPublished(const PartState& state) override;
  void onConnection(bool up) override;

  bool paused(Micros now) const { return now < pausedUntil; }
  bool inSession() const { return connection && connection->stage() == ServerConnection::Stage::ready; }
  Micros local(Micros now) const { return now + clockOffset; }

  const std::string& name() const { return description.name; }

  Simulation& simulation;
  std::size_t index;
  const ScenarioSite& description;
  Micros clockOffset, joinsAt, pausedUntil = 0;
  SiteId id = kNoSite;
  std::unique_ptr<Exchange> exchange;
  std::unique_ptr<HandLoop> hand;
  std::unique_ptr<ServerConnection> connection;
  ScriptedDevice device;
  HandMeasures measures;
  glm::dvec3 lastTarget{0.0, 0.0, 0.0};
  double sourceEnergy = 0.0;
  std::vector<Pose> lastPoses;  // of every part, as of the last tick here
  std::vector<Pose> drawn;      // of every part, as a window here would show it
  std::uint64_t packetsBefore = 0, bytesBefore = 0, droppedStates = 0, denials = 0;
  Traffic sentBefore;  // by what crashed since

 private:
  HandSettingsInput settings() const;
  void tickHand(Micros now);
  void noteContact(PartId part, HandSample& measured) const;
  void addSources(const haptics::TickOutput& tick);
  void countTransport();
};

class Simulation {
 public:
  Simulation(const Scenario& script, const haptics::ContactScene& parts, const SimulationOptions& options)
      : scenario(script),
        scene(parts.scene()),
        contact(parts),
        package(assets::packScene(parts.scene())),
        network(options.seed, script.network),
        conditions(script.network),
        invariants(script.sites.size(), LeaseRules{}),
        watch(options.watch),
        mistake(options.mistake) {
    key.seed.fill(static_cast<std::uint8_t>(options.seed));
    if (!options.tracePath.empty()) {
      trace.open(options.tracePath);
      trace << "t,site,hx,hy,hz,px,py,pz,fx,fy,fz,held,flags,links,fade,play_out_ms,lx,ly,lz\n";
    }
  }

  Status addSites(std::uint64_t seed);
  Status run();
  SimulationResult result();

  void startServer();
  void killServer();
  void stepServer();
  void applyFaults();
  void compareReplicas();
  void showSites();

  const Scenario& scenario;
  const assets::Scene& scene;
  const haptics::ContactScene& contact;
  std::vector<std::byte> package;
  VirtualNetwork network;
  NetworkConditions conditions;
  Invariants invariants;
  std::function<void(double, std::span<const SimulatedSiteState>)> watch;
  Mistake mistake;
  server::SigningKey key;
  server::MemoryJournal journal;
  std::unique_ptr<Transport> serverTransport;
  std::unique_ptr<server::Session> session;
  Micros now = 0, serverClockOffset = 0, restartAt = -1;
  std::vector<std::unique_ptr<SimulatedSite>> sites;
  std::vector<bool> faultDone, blackoutDone, stepDone;
  std::vector<std::pair<Micros, std::size_t>> rejoin;
  std::vector<bool> allStill, undisturbed;  // a tick each
  std::vector<bool> everOwned;
  Fingerprint fingerprint;
  std::ofstream trace;
  double linkWork = 0.0, linkWorkMost = 0.0;  // J, on all replicas
  struct Distances {
    double squares = 0.0, most = 0.0;
    std::uint64_t count = 0;
    void add(double distance) {
      squares += distance * distance;
      most = std::max(most, distance);
      ++count;
    }
    double rms() const { return count > 0 ? std::sqrt(squares / static_cast<double>(count)) : 0.0; }
  };
  Distances displayed, shared;
  Micros sharedTicks = 0;
};

// ---- a site ----

SimulatedSite::SimulatedSite(Simulation& sim, std::size_t siteIndex, const ScenarioSite& siteDescription,
                             HandScript script, const haptics::ContactScene& contact, const Pose& start,
                             Micros offset)
    : simulation(sim),
      index(siteIndex),
      description(siteDescription),
      clockOffset(offset),
      joinsAt(static_cast<Micros>(description.joins * 1e6)),
      exchange(std::make_unique<Exchange>()),
      hand(std::make_unique<HandLoop>(contact, *exchange)),
      device(sim.scene, std::move(script), description.arm, description.device, start,
             [this](PartId part) { return hand->worldFromPart(part); }) {
  lastTarget = start.position;
  for (const assets::Part& part : sim.scene.parts) lastPoses.push_back(part.worldFromPart);
  drawn = lastPoses;
  exchange->settings.write(settings());
}

/// What this site's ticks are given: the plain defaults, so that scenarios compare whatever the device, or on
/// request what a device of this kind gets in a real session.
HandSettingsInput SimulatedSite::settings() const {
  HandSettingsInput settings;
  haptics::TickParameters& parameters = settings.parameters;
  if (description.fit) haptics::fitToDevice(device.limits(), 0.0, parameters);
  parameters.forceLimit = description.device.forceMax;
  parameters.gravity = simulation.scene.gravity;
  if (description.stiffness > 0.0) {
    parameters.stiffness = parameters.graspStiffness = description.stiffness;
    parameters.stiffnessLimit = 0.0;
  }
  return settings;
}

void SimulatedSite::start() {
  ConnectionOptions options;
  options.name = description.name;
  options.rates.most = simulation.scenario.packetHz;
  options.rates.deadband = description.deadband;
  options.token =
      simulation.session ? simulation.session->makeToken(roleOf(description.role), kWallClock + 86400) : "";
  connection = std::make_unique<ServerConnection>(options, [this]() -> Result<std::unique_ptr<Transport>> {
    countTransport();
    return simulation.network.connect(name());
  });
  connection->setObserver(this);
}

void SimulatedSite::countTransport() {
  if (!connection || !connection->transport()) return;
  packetsBefore += connection->transport()->counters().statePacketsOut;
  bytesBefore +=
      connection->transport()->counters().stateBytesOut + connection->transport()->counters().controlBytesOut;
}

void SimulatedSite::crash() {
  countTransport();
  if (connection) {
    droppedStates += connection->statistics().droppedStates;
    sentBefore.add(connection->statistics().sent);
    simulation.invariants.onDead(index, id);
  }
  connection.reset();
  id = kNoSite;
  // The process is gone with all that it knew; arm and device stay in the world.
  exchange = std::make_unique<Exchange>();
  exchange->settings.write(settings());
  hand = std::make_unique<HandLoop>(simulation.contact, *exchange);
}

void SimulatedSite::step(Micros now) {
  tickHand(now);
  if (paused(now) || !connection) return;
  connection->step(local(now));
  if (connection->stage() == ServerConnection::Stage::needScene) connection->skipTransfer();
  if (connection->stage() == ServerConnection::Stage::haveScene)
    connection->sceneReady(simulation.scene, *exchange);
  id = connection->welcome().site;
  if (connection->stage() == ServerConnection::Stage::ended) simulation.invariants.onConnection(index, false);
}

void SimulatedSite::noteContact(PartId part, HandSample& measured) const {
  if (!simulation.scene.parts[part].movable) {
    measured.pressing = true;
  } else {
    measured.brushes = true;
    measured.pushed = measured.pushed || hand->worldFromPart(part).position != lastPoses[part].position;
  }
}

void SimulatedSite::tickHand(Micros now) {
  const haptics::DeviceSample sample = device.poll(toSeconds(now));
  Wrench wrench;
  // Before the program is started, while it stands still and when it is dead, the device's watchdog gives zero force.
  const bool running = !paused(now) && connection;
  if (running) {
    hand->setWish(device.wish());
    hand->setControl(device.control());
    wrench = hand->tick(sample, local(now));
  }
  device.apply(wrench);
  const haptics::TickOutput& tick = hand->output().tick;
  HandSample measured;
  measured.force = wrench.force;
  measured.position = device.hand().devicePose().position;
  measured.energyGiven = device.hand().energyGiven() - sourceEnergy;
  for (int i = 0; i < tick.contactCount; ++i)
    noteContact(tick.contacts[static_cast<std::size_t>(i)].part, measured);
  if (running) addSources(tick);
  ShownPose shown;
  while (exchange->shown.pop(shown)) drawn[shown.part] = shown.worldFromDrawn;
  const glm::dvec3 target = device.target().worldFromTarget.position;
  measured.still = target == lastTarget;
  lastTarget = target;
  measures.add(measured);
  simulation.fingerprint.add(wrench.force);
  simulation.fingerprint.add(measured.position);
  if (simulation.trace.is_open() && now % (10 * kMillisecond) == 0) {
    const haptics::OwnedPart* held = tick.simulated(tick.held);
    const haptics::TieReport tie = held != nullptr ? held->tie : haptics::TieReport{};
    char line[400];
    const glm::dvec3& p = tick.worldFromProxy.position;
    std::snprintf(line, sizeof line,
                  "%.3f,%s,%.6f,%.6f,%.6f,%.6f,%.6f,%.6f,%.5f,%.5f,%.5f,%s,%u,%d,%.3f,%.1f,%.5f,%.5f,%.5f\n",
                  toSeconds(now), name().c_str(), measured.position.x, measured.position.y,
                  measured.position.z, p.x, p.y, p.z, wrench.force.x, wrench.force.y, wrench.force.z,
                  tick.held == kNoPart ? "" : simulation.scene.parts[tick.held].name.c_str(), tick.flags,
                  tie.links, tie.fade, tie.delay * 1e3, tie.pull.force.x, tie.pull.force.y, tie.pull.force.z);
    simulation.trace << line;
  }
}

/// What the scene itself gave to this hand in this tick was not created: the weight of a held part, the
/// work of parts that others push against the tool, and what force fields give by their laws. Nor was what came over
/// links: whether those create energy is seen in all of them together. What leads a replica may give some: no sum of it
/// is kept.
void SimulatedSite::addSources(const haptics::TickOutput& tick) {
  const assets::Scene& scene = simulation.scene;
  sourceEnergy += tick.sourcePower * toSeconds(kTick);
  for (int i = 0; i < tick.ownedCount; ++i) {
    const haptics::OwnedPart& part = tick.owned[static_cast<std::size_t>(i)];
    if (part.tie.links == 0) continue;
    const glm::dvec3 centre =
        transformPoint(part.worldFromPart, scene.parts[part.part].massProperties.centreOfMass);
    const glm::dvec3 velocity = velocityAt(part.worldFromPart, part.twist, centre);
    const auto workOf = [&](const Wrench& wrench) {
      return toSeconds(kTick) *
             (glm::dot(wrench.force, velocity) + glm::dot(wrench.torque, part.twist.angular));
    };
    const double work = workOf(part.tie.pull);
    sourceEnergy += work + workOf(part.tie.lead);
    simulation.linkWork += work;
  }
  if (tick.held != kNoPart) {
    const assets::Part& part = scene.parts[tick.held];
    sourceEnergy += part.massProperties.mass * part.gravityFactor *
                    glm::dot(scene.gravity, device.hand().deviceVelocity()) * toSeconds(kTick);
  }
  for (int i = 0; i < tick.contactCount; ++i) {
    const haptics::Contact& contact = tick.contacts[static_cast<std::size_t>(i)];
    const Pose now = hand->worldFromPart(contact.part);
    const glm::dvec3 before =
        transformPoint(lastPoses[contact.part], transformPoint(inverse(now), contact.point));
    sourceEnergy += contact.force * std::max(0.0, glm::dot(contact.normal, contact.point - before));
  }
  for (std::size_t i = 0; i < lastPoses.size(); ++i)
    if (scene.parts[i].movable) lastPoses[i] = hand->worldFromPart(static_cast<PartId>(i));
}

void SimulatedSite::onOwnership(const PartRecord& record) {
  simulation.invariants.onOwnership(index, record);
  simulation.everOwned[record.part] = true;
  if (record.owner == connection->welcome().site || hand->output().tick.held == record.part)
    measures.roleChanged();
}
void SimulatedSite::onGrab(const Grab& grab) { simulation.invariants.onGrab(index, grab); }
void SimulatedSite::onRelease(const Release& release) { simulation.invariants.onRelease(release); }
void SimulatedSite::onGrabReply(const GrabReply& reply) {
  if (reply.denial != Denial::none) ++denials;
  simulation.invariants.onGrabReply(index, reply);
}
void SimulatedSite::onAccepted(SiteId, const PartState& state) {
  simulation.invariants.onAccepted(index, state);
}
void SimulatedSite::onPublished(const PartState& state) {
  simulation.invariants.onPublished(index, connection->welcome().site, state);
}
void SimulatedSite::onConnection(bool up) { simulation.invariants.onConnection(index, up); }

// ---- the session ----

Status Simulation::addSites(std::uint64_t seed) {
  std::mt19937_64 random(seed * 0x9e3779b97f4a7c15ull + 1);
  for (std::size_t i = 0; i < scenario.sites.size(); ++i) {
    const ScenarioSite& description = scenario.sites[i];
    Result<HandScript> script = parseHandScript(
        description.script, scenario.path + ": sites[" + std::to_string(i) + "].script", scene);
    if (!script) return script.error();
    const Pose start =
        description.hasStart ? Pose{description.start, {1.0, 0.0, 0.0, 0.0}} : defaultHandStart(scene, i);
    // Each site's clock started some time in the last eleven days.
    const auto offset = static_cast<Micros>(random() % 1000000000000ull);
    sites.push_back(
        std::make_unique<SimulatedSite>(*this, i, description, std::move(*script), contact, start, offset));
  }
  faultDone.assign(scenario.faults.size(), false);
  blackoutDone.assign(scenario.blackouts.size(), false);
  stepDone.assign(scenario.steps.size(), false);
  everOwned.assign(scene.parts.size(), false);
  return {};
}

void Simulation::startServer() {
  server::SessionConfig config;
  config.key = key;
  config.maxSites = kMaxSites;
  if (mistake == Mistake::regrantedEarly) config.lease.driftPpm = -9e5;
  serverTransport = network.listen();
  const server::JournalContents kept = journal.contents();
  serverClockOffset = kept.sessionTime - now;  // a new process: its clock goes on from what the journal knows
  session = std::make_unique<server::Session>(scene, package, config, *serverTransport, journal, nullptr,
                                              now + serverClockOffset, kWallClock + now / kSecond);
  if (now > 0) invariants.onServerRestart(kept.parts);
}

void Simulation::killServer() {
  session.reset();
  serverTransport.reset();
  journal.crash();
  if (mistake == Mistake::journalForgotten) journal = server::MemoryJournal{};
}

void Simulation::stepServer() {
  if (!session) return;
  session->step(now + serverClockOffset, kWallClock + now / kSecond);
  for (std::size_t i = 0; i < scene.parts.size(); ++i)
    if (const PartRecord& record = session->ownership().part(static_cast<PartId>(i)); record.epoch > 0)
      invariants.onServerRecord(record);
}

void Simulation::applyFaults() {
  const double t = toSeconds(now);
  for (std::size_t i = 0; i < scenario.faults.size(); ++i) {
    const Fault& fault = scenario.faults[i];
    if (faultDone[i] || t < fault.at) continue;
    faultDone[i] = true;
    const Micros until = now + static_cast<Micros>(std::max(fault.lasts, 0.0) * 1e6);
    if (fault.kind == Fault::Kind::killServer) {
      killServer();
      if (fault.lasts >= 0.0) restartAt = until;
      continue;
    }
    for (auto& site : sites) {
      if (site->name() != fault.site) continue;
      if (fault.kind == Fault::Kind::pauseSite) {
        site->pausedUntil = until;
      } else {
        site->crash();
        if (fault.lasts >= 0.0) rejoin.emplace_back(until, site->index);
      }
    }
  }
  if (restartAt >= 0 && now >= restartAt) {
    restartAt = -1;
    startServer();
  }
  for (auto& [at, index] : rejoin)
    if (at >= 0 && now >= at && session) {
      if (!sites[index]->connection) sites[index]->start();  // else it was killed before it had joined
      at = -1;
    }
  for (std::size_t i = 0; i < scenario.blackouts.size(); ++i)
    if (!blackoutDone[i] && t >= scenario.blackouts[i].at) {
      blackoutDone[i] = true;
      network.blackout(scenario.blackouts[i].site,
                       now + static_cast<Micros>(scenario.blackouts[i].lasts * 1e6));
    }
  for (std::size_t i = 0; i < scenario.steps.size(); ++i)
    if (!stepDone[i] && t >= scenario.steps[i].at) {
      stepDone[i] = true;
      conditions.oneWay = scenario.steps[i].oneWay;
      network.setConditions(conditions);
    }
}

/// The owner's part against what every other site shows of it at this instant, and against its replicas.
void Simulation::compareReplicas() {
  linkWorkMost = std::max(linkWorkMost, linkWork);
  bool anyShared = false;
  for (const auto& owner : sites) {
    if (!owner->inSession()) continue;
    const haptics::TickOutput& tick = owner->hand->output().tick;
    for (int i = 0; i < tick.ownedCount; ++i) {
      const haptics::OwnedPart& part = tick.owned[static_cast<std::size_t>(i)];
      fingerprint.add(part.worldFromPart.position);
      if (owner->connection->owner(part.part) != owner->id) continue;  // a guest
      for (const auto& other : sites) {
        if (other == owner || !other->inSession()) continue;
        displayed.add(glm::length(other->drawn[part.part].position - part.worldFromPart.position));
        if (other->hand->output().tick.simulated(part.part) == nullptr) continue;
        shared.add(glm::length(other->hand->worldFromPart(part.part).position - part.worldFromPart.position));
        anyShared = true;
      }
    }
  }
  sharedTicks += anyShared ? 1 : 0;
}

void Simulation::showSites() {
  std::vector<SimulatedSiteState> states;
  for (const auto& site : sites) {
    const HandSample& sample = site->measures.samples().back();
    states.push_back({sample.position, sample.force, &site->hand->output().tick});
  }
  watch(toSeconds(now), states);
}

Status Simulation::run() {
  startServer();
  const auto ticks = static_cast<Micros>(std::llround(scenario.duration * 1e3));
  for (Micros tick = 0; tick < ticks; ++tick) {
    now = tick * kTick;
    invariants.setTime(now);
    network.advanceTo(now);
    journal.advanceTo(now);
    applyFaults();
    stepServer();
    bool still = true, slidOff = false;
    for (auto& site : sites) {
      if (!site->connection && site->joinsAt >= 0 && now >= site->joinsAt && session) {
        site->joinsAt = -1;
        site->start();
      }
      site->step(now);
      still = still && site->measures.samples().back().still;
      slidOff = slidOff || site->measures.slidOff();
    }
    allStill.push_back(still);
    undisturbed.push_back(still && !slidOff);
    compareReplicas();
    if (watch) showSites();
  }
  return {};
}

SimulationResult Simulation::result() {
  SimulationResult result;
  std::vector<std::pair<std::string, double>> replicaErrors;
  for (std::size_t part = 0; part < scene.parts.size(); ++part) {
    if (!everOwned[part]) continue;
    const SimulatedSite* first = nullptr;
    double error = 0.0;
    for (const auto& site : sites) {
      if (!site->inSession() || site->connection->owner(static_cast<PartId>(part)) != kNoSite) continue;
      const Pose& pose = site->hand->worldFromPart(static_cast<PartId>(part));
      if (first)
        error = std::max(error, glm::length(pose.position -
                                            first->hand->worldFromPart(static_cast<PartId>(part)).position));
      else
        result.finalPoses[scene.parts[part].name] = pose;
      if (!first) first = site.get();
    }
    replicaErrors.emplace_back(scene.parts[part].name, error);
  }
  invariants.finish(replicaErrors);
  for (const auto& site : sites) {
    SimulatedSiteResult& out = result.sites[site->name()];
    out.energyCreated = site->measures.energyCreated();
    out.feltStiffness = site->measures.feltStiffness();
    out.forceStep20ms = site->measures.forceStep();
    out.handoverExcess = site->measures.handoverExcess();
    out.rmsForce = site->measures.rmsForce();
    out.mostForce = site->measures.mostForce();
    const TransportCounters counters = site->connection && site->connection->transport()
                                           ? site->connection->transport()->counters()
                                           : TransportCounters{};
    out.packetsPerSecond =
        static_cast<double>(site->packetsBefore + counters.statePacketsOut) / scenario.duration;
    out.sent = site->sentBefore;
    if (site->connection) out.sent.add(site->connection->statistics().sent);
    out.bytesPerSecond =
        static_cast<double>(site->bytesBefore + counters.stateBytesOut + counters.controlBytesOut) /
        scenario.duration;
    out.calm = site->measures.calm(undisturbed);
    out.pushed = site->measures.pushed();
    result.stable = result.stable && site->measures.stable(allStill);
    result.siteNames[site->id] = site->name();
    result.droppedStates +=
        site->droppedStates + (site->connection ? site->connection->statistics().droppedStates : 0);
    result.denials += site->denials;
  }
  result.displayedRms = displayed.rms();
  result.displayedMax = displayed.most;
  result.discrepancyRms = shared.rms();
  result.discrepancyMax = shared.most;
  result.shared = toSeconds(sharedTicks * kTick);
  result.energyOfLinks = linkWorkMost;
  result.grants = invariants.grants();
  result.violations = invariants.violations();
  for (const assets::Part& part : scene.parts) result.partNames.push_back(part.name);
  result.hash = fingerprint.hex();
  return result;
}

/// The site that owned a part first, or the first of the list.
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
  Simulation simulation(scenario, contact, options);
  if (Status status = simulation.addSites(options.seed); !status) return status.error();
  if (!options.tracePath.empty() && !simulation.trace)
    return Error{options.tracePath + ": cannot be written"};
  if (Status status = simulation.run(); !status) return status.error();
  simulation.trace.flush();
  if (!options.tracePath.empty() && !simulation.trace)
    return Error{options.tracePath + ": cannot be written"};
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
