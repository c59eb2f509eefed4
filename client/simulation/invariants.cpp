#include "client/simulation/invariants.h"

#include <algorithm>

namespace tandem::client {

using sync::Micros;
using sync::PartRecord;

namespace {

constexpr Micros kAnswerLimit =
    10 * sync::kSecond;                     // L1 in a session whose server is up: far above any round trip
constexpr double kReplicaTolerance = 1e-5;  // m, L4: a few quanta of the wire

std::string text(const PartRecord& record) {
  return "part " + std::to_string(record.part) + " epoch " + std::to_string(record.epoch) + " owner " +
         std::to_string(record.owner);
}

}  // namespace

Invariants::Invariants(std::size_t sites, sync::LeaseRules lease)
    : lease_(lease), seen_(sites), open_(sites) {}

void Invariants::broken(const char* rule, std::string what) {
  violations_.push_back({rule, sync::toSeconds(now_), std::move(what)});
}

void Invariants::onOwnership(std::size_t site, const PartRecord& record) {
  SeenPart& seen = seen_[site][record.part];
  if (record.epoch < seen.epoch) broken("S2", "site took an older ownership: " + text(record));
  if (record.epoch > seen.epoch) seen = {record.epoch, 0};
  if (record.owner == kNoSite) return;
  const auto [entry, fresh] = ownerOf_.emplace(std::pair{record.part, record.epoch}, record.owner);
  if (!fresh && entry->second != record.owner) broken("S1", "two owners in one epoch: " + text(record));
}

void Invariants::onGrab(std::size_t site, const sync::Grab& grab) {
  open_[site][grab.request] = {grab.part, now_};
}

void Invariants::onGrabReply(std::size_t site, const sync::GrabReply& reply) {
  open_[site].erase(reply.request);
  const auto [entry, fresh] = answers_.emplace(std::pair{site, reply.request}, reply);
  if (!fresh && (entry->second.denial != reply.denial || entry->second.part.epoch != reply.part.epoch))
    broken("S7", "one request, two answers: " + text(reply.part));
  if (reply.denial == sync::Denial::ownedByOther && reply.part.owner == kNoSite)
    broken("S4", "denied without a winner: " + text(reply.part));
}

void Invariants::onAccepted(std::size_t site, const sync::PartState& state) {
  SeenPart& seen = seen_[site][state.part];
  if (state.epoch != seen.epoch)
    broken("S2", "site applied a state of epoch " + std::to_string(state.epoch) + " in epoch " +
                     std::to_string(seen.epoch) + " of part " + std::to_string(state.part));
  else if (state.sequence <= seen.sequence)
    broken("S2", "site applied an older state of part " + std::to_string(state.part));
  seen.sequence = std::max(seen.sequence, state.sequence);
}

void Invariants::onPublished(std::size_t, SiteId self, const sync::PartState& state) {
  // S3: once the server has given the part to somebody else, the former owner is silent, whatever it has been
  // told.
  const auto record = server_.find(state.part);
  if (record != server_.end() && record->second.owner != kNoSite && record->second.epoch > state.epoch &&
      record->second.owner != self)
    broken("S3", "site " + std::to_string(self) + " still publishes part " + std::to_string(state.part) +
                     " epoch " + std::to_string(state.epoch));
}

/// From here on that owner says nothing of the part any more.
void Invariants::onRelease(const sync::Release& release) {
  const auto kept = restored_.find(release.part);
  if (kept != restored_.end() && kept->second.epoch == release.epoch) restored_.erase(kept);
}

void Invariants::onConnection(std::size_t site, bool up) {
  if (!up) open_[site].clear();  // a lost connection is an answer: the person is told
}

void Invariants::onDead(std::size_t site, SiteId self) {
  open_[site].clear();
  // Whoever comes back in its place is another site: it counts its requests, and what it has seen, anew.
  answers_.erase(answers_.lower_bound({site, 0}), answers_.lower_bound({site + 1, 0}));
  seen_[site].clear();
  if (self != kNoSite) deadSince_[self] = now_;
}

void Invariants::onServerRecord(const PartRecord& record) {
  PartRecord& before = server_[record.part];
  if (record.epoch < before.epoch) broken("S1", "the server's epoch went back: " + text(record));
  const bool granted = record.owner != kNoSite && record.epoch > before.epoch;
  if (granted) {
    grants_.push_back({sync::toSeconds(now_), record.part, record.owner, record.epoch});
    const auto kept = restored_.find(record.part);
    if (restartedAt_ >= 0 && now_ < restartedAt_ + lease_.lease && kept != restored_.end() &&
        kept->second.owner != kNoSite && kept->second.owner != record.owner)
      broken("S8", "granted while an earlier owner may still hold it: " + text(record));
  }
  // L2: what a dead site owned is free after its lease and the drift of clocks; a restart begins a new lease.
  const auto dead = deadSince_.find(record.owner);
  if (dead != deadSince_.end()) {
    const auto drift = static_cast<Micros>(static_cast<double>(lease_.lease) * lease_.driftPpm * 1e-6);
    const Micros since = std::max(dead->second, restartedAt_);
    if (now_ > since + lease_.lease + drift + sync::kSecond)
      broken("L2", "a dead site still owns: " + text(record));
  }
  before = record;
}

void Invariants::onServerRestart(const std::vector<PartRecord>& restored) {
  restartedAt_ = now_;
  restored_.clear();
  for (const PartRecord& record : restored) restored_[record.part] = record;
  for (auto& [part, record] : server_) {
    // A grant that nobody was told of may be lost with the crash; one that somebody was told of may not (S1).
    const auto told = ownerOf_.find({part, record.epoch});
    const auto kept = restored_.find(part);
    const Epoch epoch = kept == restored_.end() ? 0 : kept->second.epoch;
    if (told != ownerOf_.end() && epoch < record.epoch) broken("S1", "the journal lost " + text(record));
    record = kept == restored_.end() ? PartRecord{part, kNoSite, 0, {}} : kept->second;
  }
}

void Invariants::finish(const std::vector<std::pair<std::string, double>>& replicaErrors) {
  for (const auto& requests : open_)
    for (const auto& [request, open] : requests)
      if (now_ - open.at > kAnswerLimit)
        broken("L1", "request " + std::to_string(request) + " for part " + std::to_string(open.part) +
                         " unanswered");
  for (const auto& [name, error] : replicaErrors)
    if (error > kReplicaTolerance)
      broken("L4", "replicas of " + name + " differ by " + std::to_string(error) + " m");
}

}  // namespace tandem::client
