#include "client/simulation/fault_schedule.h"

#include <algorithm>
#include <cmath>

#include "assets/base/assert.h"

namespace tandem::client {

using namespace sync;
using Kind = Fault::Kind;

namespace {

/// Somebody looks at a damaged journal, recovers it and starts the server: by then all leases are over.
constexpr Micros kRecovery = 3 * kSecond;
constexpr Micros kForEver = Micros{1} << 50;

Micros micros(double seconds) { return static_cast<Micros>(std::llround(seconds * 1e6)); }

}  // namespace

FaultSchedule::FaultSchedule(const Scenario& scenario, const assets::Scene& scene, VirtualNetwork& network,
                             SimulatedServer& server, Invariants& invariants, std::uint64_t seed)
    : scenario_(scenario),
      scene_(scene),
      network_(network),
      server_(server),
      invariants_(invariants),
      seed_(seed),
      conditions_(scenario.network),
      blackoutDone_(scenario.blackouts.size(), false),
      stepDone_(scenario.steps.size(), false) {
  for (std::size_t i = 0; i < scenario.faults.size(); ++i)
    due_.push_back({micros(scenario.faults[i].at), i, false});
  std::stable_sort(due_.begin(), due_.end(), [](const Entry& a, const Entry& b) { return a.at < b.at; });
  std::reverse(due_.begin(), due_.end());
}

Micros FaultSchedule::untilOf(const Fault& fault) const {
  return fault.lasts < 0.0 ? kForEver : now_ + micros(fault.lasts);
}

FaultySite* FaultSchedule::find(const std::string& name) {
  const auto found = std::find_if(sites_.begin(), sites_.end(),
                                  [&](const FaultySite* site) { return site->name() == name; });
  return found == sites_.end() ? nullptr : *found;
}

void FaultSchedule::advanceTo(Micros now) {
  ASSERT(now >= now_);
  now_ = now;
  if (!calm_ && scenario_.calmFrom >= 0.0 && now >= micros(scenario_.calmFrom)) becomeCalm();
  while (!due_.empty() && due_.back().at <= now) {
    const Entry entry = due_.back();
    due_.pop_back();
    const Fault& fault = scenario_.faults[entry.fault];
    if (calm_ && !fault.isDeed()) continue;
    if (entry.ends) {
      end(fault);
      continue;
    }
    apply(fault);
    if (fault.lasts < 0.0) continue;
    // Behind those that are due at the same time.
    const Entry over{now + micros(fault.lasts), entry.fault, true};
    due_.insert(std::find_if(due_.begin(), due_.end(), [&](const Entry& e) { return e.at <= over.at; }),
                over);
  }
  restart();
  applyNetworkSteps();
  hearTheDead();
  for (const auto& stranger : strangers_) stranger->step(now);
}

void FaultSchedule::hearTheDead() {
  if (network_.heardFromTheDead() == heardFromTheDead_) return;
  heardFromTheDead_ = network_.heardFromTheDead();
  for (std::size_t i = 0; i < sites_.size(); ++i)
    invariants_.onHeardFromTheDead(i, network_.lastFromTheDead(sites_[i]->name()));
}

Micros FaultSchedule::nextDue(Micros never) const {
  Micros next = never;
  if (!due_.empty()) next = std::min(next, due_.back().at);
  if (!calm_ && scenario_.calmFrom >= 0.0) next = std::min(next, micros(scenario_.calmFrom));
  if (serverRestartsAt_ >= 0) next = std::min(next, serverRestartsAt_);
  for (const auto& [at, site] : rejoin_)
    if (at >= 0 && server_.running()) next = std::min(next, std::max(at, now_));
  for (std::size_t i = 0; !calm_ && i < stepDone_.size(); ++i)
    if (!stepDone_[i]) next = std::min(next, micros(scenario_.steps[i].at));
  for (std::size_t i = 0; !calm_ && i < blackoutDone_.size(); ++i)
    if (!blackoutDone_[i]) next = std::min(next, micros(scenario_.blackouts[i].at));
  for (const auto& stranger : strangers_) next = std::min(next, stranger->nextDue(never));
  return std::max(next, now_);
}

void FaultSchedule::apply(const Fault& fault) {
  if (fault.ofStranger()) {
    strangers_.push_back(std::make_unique<Stranger>(Stranger::Ground{network_, server_, invariants_, scene_},
                                                    fault.kind,
                                                    "stranger " + std::to_string(strangers_.size()),
                                                    seed_ * 31 + strangers_.size(), now_, untilOf(fault)));
    return;
  }
  switch (fault.kind) {
    case Kind::killServer:
    case Kind::pauseServer:
    case Kind::wallStep:
      return applyToServer(fault);
    case Kind::diskFails:
    case Kind::diskSlow:
    case Kind::diskTears:
    case Kind::diskRots:
    case Kind::diskLies:
      return applyToDisk(fault, false);
    case Kind::drift:
      return setDrift(fault.site, fault.amount);
    case Kind::cutUp:
    case Kind::cutDown:
    case Kind::delay:
    case Kind::burst:
    case Kind::uplink:
      return applyToNetwork(fault, false);
    default:
      return applyToSite(fault);
  }
}

void FaultSchedule::end(const Fault& fault) {
  if (fault.kind == Kind::drift) return setDrift(fault.site, 0.0);
  if (fault.kind >= Kind::diskFails && fault.kind <= Kind::diskLies) return applyToDisk(fault, true);
  if (fault.kind >= Kind::cutUp && fault.kind <= Kind::uplink) return applyToNetwork(fault, true);
}

void FaultSchedule::applyToServer(const Fault& fault) {
  if (fault.kind == Kind::wallStep) return server_.stepWallClock(std::llround(fault.amount));
  if (fault.kind == Kind::pauseServer) return server_.pauseUntil(untilOf(fault));
  server_.kill();
  if (fault.lasts >= 0.0) serverRestartsAt_ = untilOf(fault);
  if (server_.journal().damaged()) serverRestartsAt_ = std::max(serverRestartsAt_, now_ + kRecovery);
}

void FaultSchedule::applyToDisk(const Fault& fault, bool ends) {
  FaultyJournal& journal = server_.journal();
  switch (fault.kind) {
    case Kind::diskFails:
      return journal.setFailing(!ends);
    case Kind::diskSlow:
      return journal.setDelay(ends ? kMillisecond : micros(fault.amount));
    case Kind::diskTears:
      return journal.setTearing(!ends);
    case Kind::diskLies:
      return journal.setLying(!ends);
    default:
      if (!ends) journal.rot();
      if (serverRestartsAt_ >= 0) serverRestartsAt_ = std::max(serverRestartsAt_, now_ + kRecovery);
  }
}

void FaultSchedule::setDrift(const std::string& name, double ppm) {
  if (name == "server") server_.setDrift(ppm, now_);
  if (FaultySite* site = find(name)) site->setDrift(ppm, now_);
}

void FaultSchedule::applyToNetwork(const Fault& fault, bool ends) {
  if (fault.kind == Kind::cutUp || fault.kind == Kind::cutDown) {
    using Way = VirtualNetwork::Way;
    if (!ends)
      network_.cut(fault.site, fault.kind == Kind::cutUp ? Way::toServer : Way::toSite, untilOf(fault));
    return;
  }
  for (const FaultySite* site : sites_) {
    if (site->name() != fault.site && fault.site != "all") continue;
    VirtualNetwork::Path path = network_.path(site->name());
    const double amount = ends ? 0.0 : fault.amount;
    if (fault.kind == Kind::delay) path.delay = micros(amount);
    if (fault.kind == Kind::burst) path.loss = amount;
    if (fault.kind == Kind::uplink) path.uplinkRate = amount;
    network_.setPath(site->name(), path);
  }
}

void FaultSchedule::applyToSite(const Fault& fault) {
  FaultySite* site = find(fault.site);
  if (site == nullptr) return;
  switch (fault.kind) {
    case Kind::pauseSite:
      return site->pauseUntil(untilOf(fault));
    case Kind::killSite:
      site->crash();
      if (fault.lasts >= 0.0) rejoin_.emplace_back(untilOf(fault), site);
      return;
    case Kind::leave:
      return site->leave();
    case Kind::reset:
      return site->resetParts();
    default:
      break;
  }
  ASSERT(fault.kind == Kind::revoke);
  for (std::size_t part = 0; part < scene_.parts.size(); ++part)
    if (scene_.parts[part].name == fault.part) site->revoke(static_cast<PartId>(part));
}

/// Starts what was killed and is due again. A site waits for the server; it may run already if it was killed
/// before it had joined.
void FaultSchedule::restart() {
  if (serverRestartsAt_ >= 0 && now_ >= serverRestartsAt_) {
    serverRestartsAt_ = -1;
    if (!server_.running()) server_.start(now_, invariants_);
  }
  for (auto& [at, site] : rejoin_) {
    if (at < 0 || now_ < at || !server_.running()) continue;
    if (!site->started()) site->start();
    at = -1;
  }
}

void FaultSchedule::applyNetworkSteps() {
  for (std::size_t i = 0; !calm_ && i < blackoutDone_.size(); ++i) {
    const Blackout& blackout = scenario_.blackouts[i];
    if (blackoutDone_[i] || now_ < micros(blackout.at)) continue;
    blackoutDone_[i] = true;
    network_.blackout(blackout.site, now_ + micros(blackout.lasts));
  }
  for (std::size_t i = 0; !calm_ && i < stepDone_.size(); ++i) {
    if (stepDone_[i] || now_ < micros(scenario_.steps[i].at)) continue;
    stepDone_[i] = true;
    conditions_.oneWay = scenario_.steps[i].oneWay;
    network_.setConditions(conditions_);
  }
}

void FaultSchedule::becomeCalm() {
  calm_ = true;
  conditions_ = {};
  conditions_.oneWay = scenario_.network.oneWay;
  network_.setConditions(conditions_);
  network_.healAll();
  strangers_.clear();
  server_.journal().heal();
  server_.setDrift(0.0, now_);
  if (server_.paused(now_)) server_.pauseUntil(now_);
  // A server whose journal has failed is started again by whoever made room on the disk.
  if (!server_.journal().failure().empty()) server_.kill();
  if (!server_.running() && serverRestartsAt_ < 0) serverRestartsAt_ = now_;
  if (!server_.running() && server_.journal().damaged()) serverRestartsAt_ = now_ + kRecovery;
  for (FaultySite* site : sites_) {
    site->setDrift(0.0, now_);
    site->pauseUntil(0);
  }
  for (auto& [at, site] : rejoin_) at = std::min(at, now_);
}

}  // namespace tandem::client
