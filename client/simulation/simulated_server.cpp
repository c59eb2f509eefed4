#include "client/simulation/simulated_server.h"

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
    : scene_(scene), network_(network), mistake_(mistake), package_(assets::packScene(scene)) {
  key_.seed.fill(static_cast<std::uint8_t>(seed));
}

void SimulatedServer::start(Micros now, Invariants& invariants) {
  ASSERT(!running());
  server::SessionConfig config;
  config.key = key_;
  if (mistake_ == Mistake::regrantedEarly) config.lease.driftPpm = -9e5;
  transport_ = network_.listen();
  const server::JournalContents kept = journal_.contents();
  clockOffset_ = kept.sessionTime - now;  // a new process: its clock goes on from what the journal knows
  session_ = std::make_unique<server::Session>(scene_, package_, config, *transport_, journal_, nullptr,
                                               now + clockOffset_, kWallClock + now / kSecond);
  if (now > 0) invariants.onServerRestart(kept.parts);
}

void SimulatedServer::kill() {
  session_.reset();
  transport_.reset();
  journal_.crash();
  if (mistake_ == Mistake::journalForgotten) journal_ = server::MemoryJournal{};
}

void SimulatedServer::step(Micros now, Invariants& invariants) {
  if (!running()) return;
  session_->step(now + clockOffset_, kWallClock + now / kSecond);
  for (std::size_t i = 0; i < scene_.parts.size(); ++i)
    if (const PartRecord& record = session_->ownership().part(static_cast<PartId>(i)); record.epoch > 0)
      invariants.onServerRecord(record);
}

std::string SimulatedServer::makeToken(const std::string& role) const {
  return running() ? session_->makeToken(roleOf(role), kWallClock + kTokenLasts) : "";
}

}  // namespace tandem::client
