#include "client/simulation/simulated_server.h"

#include <algorithm>
#include <limits>

#include "assets/base/assert.h"
#include "assets/scene/scene_package.h"

namespace tandem::client {

using namespace sync;

namespace {

constexpr std::int64_t kWallClock = 1700000000;  // Unix time at virtual time 0: any constant
constexpr std::int64_t kTokenLasts = 86400;      // s

Role roleOf(const std::string& name) {
  return name == "instructor" ? Role::instructor : name == "observer" ? Role::observer : Role::participant;
}

}  // namespace

SimulatedServer::SimulatedServer(const assets::Scene& scene, VirtualNetwork& network, std::uint64_t seed,
                                 Mistake mistake)
    : scene_(scene),
      network_(network),
      mistake_(mistake),
      package_(assets::packScene(scene)),
      journal_(seed),
      wallClocks_{{0, kWallClock}} {
  server::SigningKey::Seed bytes{};
  bytes.fill(static_cast<std::uint8_t>(seed));
  key_ = server::SigningKey(bytes);
}

void SimulatedServer::stepWallClock(std::int64_t seconds) {
  wallClocks_.push_back({now_, wallClocks_.back().atZero + seconds});
}

std::int64_t SimulatedServer::unixNow(Micros now) const { return wallClocks_.back().atZero + now / kSecond; }

std::int64_t SimulatedServer::leastUnixSince(Micros since) const {
  std::int64_t least = std::numeric_limits<std::int64_t>::max();
  Micros until = std::numeric_limits<Micros>::max();
  for (auto clock = wallClocks_.rbegin(); clock != wallClocks_.rend() && until >= since; ++clock) {
    least = std::min(least, clock->atZero + std::max(since, clock->from) / kSecond);
    until = clock->from;
  }
  return least;
}

void SimulatedServer::start(Micros now, Invariants& invariants) {
  ASSERT(!running());
  now_ = now;
  if (journal_.restart()) {
    server::SigningKey::Seed next = key_.seed();
    ++next[0];
    key_ = server::SigningKey(next);
  }
  server::SessionConfig config;
  config.key = key_;
  if (mistake_ == Mistake::regrantedEarly) config.lease.driftPpm = -9e5;
  transport_ = network_.listen();
  pausedUntil_ = 0;
  const server::JournalContents kept = journal_.contents();
  // A new process: its clock goes on from what the journal knows.
  clockOffset_ = kept.sessionTime - clock_.at(now);
  session_ = std::make_unique<server::Session>(scene_, package_, config, *transport_, journal_, nullptr,
                                               clock_.at(now) + clockOffset_, unixNow(now));
  if (now > 0) invariants.onServerRestart(kept.parts);
}

void SimulatedServer::kill() {
  session_.reset();
  transport_.reset();
  journal_.crash();
  if (mistake_ == Mistake::journalForgotten) journal_ = FaultyJournal{1};
}

void SimulatedServer::step(Micros now, Invariants& invariants) {
  now_ = now;
  if (!running()) return invariants.onServerHindered();
  if (pausedUntil_ > 0) {
    invariants.onServerHindered();
    if (paused(now)) return;
    pausedUntil_ = 0;
  }
  session_->step(clock_.at(now) + clockOffset_, unixNow(now));
  if (!journal_.failure().empty()) invariants.onServerHindered();
  observe(invariants);
}

void SimulatedServer::observe(Invariants& invariants) const {
  const OwnershipTable& table = session_->ownership();
  for (std::size_t i = 0; i < scene_.parts.size(); ++i)
    if (const PartRecord& record = table.part(static_cast<PartId>(i)); record.epoch > 0)
      invariants.onServerRecord(record);
  invariants.onServerCoHolders(table.allCoHolders());
}

Micros SimulatedServer::nextStep(Micros now) const {
  if (paused(now)) return pausedUntil_;
  const Micros due = session_->nextDeadline() - clockOffset_;  // by the server's clock
  return now + std::max<Micros>(0, due - clock_.at(now));
}

std::string SimulatedServer::makeToken(const std::string& role) const {
  return running() ? session_->makeToken(roleOf(role), unixNow(now_) + kTokenLasts) : "";
}

std::string SimulatedServer::makeToken(Role role, std::int64_t seconds, Micros now) const {
  return running() ? session_->makeToken(role, unixNow(now) + seconds) : "";
}

std::string SimulatedServer::forgeToken(Role role) const {
  server::Ticket ticket;
  ticket.role = role;
  ticket.nonce = std::string(32, 'a');
  ticket.expires = wallClocks_.back().atZero + kTokenLasts;
  server::SigningKey::Seed other = key_.seed();
  other[1] ^= 0x55;
  return server::sign(ticket, server::SigningKey(other));
}

}  // namespace tandem::client
