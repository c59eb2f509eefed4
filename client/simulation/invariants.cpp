#include "client/simulation/invariants.h"

#include <algorithm>

#include "assets/base/assert.h"

namespace tandem::client {

using sync::Micros;
using sync::PartRecord;

namespace {

constexpr Micros kAnswerLimit = 10 * sync::kSecond;  // L1: far above any round trip
constexpr double kReplicaTolerance = 1e-5;           // m, L4: a few quanta of the wire

std::string text(const PartRecord& record) {
  return "part " + std::to_string(record.part) + " epoch " + std::to_string(record.epoch) + " owner " +
         std::to_string(record.owner);
}

}  // namespace

Invariants::Invariants(std::size_t sites, sync::LeaseRules lease)
    : lease_(lease), applied_(sites), open_(sites) {}

void Invariants::setTime(Micros now) {
  ASSERT(now >= now_);
  now_ = now;
}

void Invariants::reportBroken(const char* rule, std::string what) {
  violations_.push_back({rule, sync::toSeconds(now_), std::move(what)});
}

void Invariants::onOwnership(std::size_t site, const PartRecord& record) {
  ASSERT(site < applied_.size());
  AppliedState& applied = applied_[site][record.part];
  if (record.epoch < applied.epoch) reportBroken("S2", "site took an older ownership: " + text(record));
  if (record.epoch > applied.epoch) applied = {record.epoch, 0};
  if (record.owner == kNoSite) return;
  const auto [entry, fresh] = ownerOf_.emplace(std::pair{record.part, record.epoch}, record.owner);
  if (!fresh && entry->second != record.owner) reportBroken("S1", "two owners in one epoch: " + text(record));
}

void Invariants::onGrab(std::size_t site, const sync::Grab& grab) {
  ASSERT(site < open_.size());
  open_[site][grab.request] = {grab.part, now_};
}

void Invariants::onGrabReply(std::size_t site, const sync::GrabReply& reply) {
  open_[site].erase(reply.request);
  const auto [entry, fresh] = answers_.emplace(std::pair{site, reply.request}, reply);
  if (!fresh && (entry->second.denial != reply.denial || entry->second.part.epoch != reply.part.epoch))
    reportBroken("S7", "one request, two answers: " + text(reply.part));
  if (reply.denial == sync::Denial::ownedByOther && reply.part.owner == kNoSite)
    reportBroken("S4", "denied without a winner: " + text(reply.part));
}

void Invariants::onAccepted(std::size_t site, const sync::PartState& state) {
  ASSERT(site < applied_.size());
  AppliedState& applied = applied_[site][state.part];
  if (state.epoch != applied.epoch)
    reportBroken("S2", "site applied a state of epoch " + std::to_string(state.epoch) + " in epoch " +
                           std::to_string(applied.epoch) + " of part " + std::to_string(state.part));
  else if (state.sequence <= applied.sequence)
    reportBroken("S2", "site applied an older state of part " + std::to_string(state.part));
  applied.sequence = std::max(applied.sequence, state.sequence);
}

void Invariants::onPublished(SiteId self, const sync::PartState& state) {
  // S3: once the server has granted the part to another site, the former owner publishes nothing of it,
  // whether or not it has received word of the grant.
  const auto record = server_.find(state.part);
  if (record != server_.end() && record->second.owner != kNoSite && record->second.epoch > state.epoch &&
      record->second.owner != self)
    reportBroken("S3", "site " + std::to_string(self) + " still publishes part " +
                           std::to_string(state.part) + " epoch " + std::to_string(state.epoch));
}

/// After a release its owner publishes nothing of the part, so that the server may grant it at once (S8).
void Invariants::onRelease(const sync::Release& release) {
  const auto kept = restored_.find(release.part);
  if (kept != restored_.end() && kept->second.epoch == release.epoch) restored_.erase(kept);
}

void Invariants::onConnection(std::size_t site, bool up) {
  ASSERT(site < open_.size());
  if (!up)
    open_[site].clear();  // the client answers for the lost connection: it shows the loss to the person
}

void Invariants::onDead(std::size_t site, SiteId self) {
  ASSERT(site < open_.size());
  open_[site].clear();
  // The client that starts in its place is another site: it numbers its requests, and receives states, anew.
  answers_.erase(answers_.lower_bound({site, 0}), answers_.lower_bound({site + 1, 0}));
  applied_[site].clear();
  if (self != kNoSite) deadSince_[self] = now_;
}

void Invariants::onServerRecord(const PartRecord& record) {
  PartRecord& before = server_[record.part];
  if (record.epoch < before.epoch) reportBroken("S1", "the server's epoch went back: " + text(record));
  const bool granted = record.owner != kNoSite && record.epoch > before.epoch;
  if (granted) {
    grants_.push_back({sync::toSeconds(now_), record.part, record.owner, record.epoch});
    const auto kept = restored_.find(record.part);
    if (restartedAt_ >= 0 && now_ < restartedAt_ + lease_.lease && kept != restored_.end() &&
        kept->second.owner != kNoSite && kept->second.owner != record.owner)
      reportBroken("S8", "granted while an earlier owner may still hold it: " + text(record));
  }
  // L2: a part of a dead site is free after the lease and the drift of clocks. A restart begins a new lease.
  const auto dead = deadSince_.find(record.owner);
  if (dead != deadSince_.end()) {
    const auto drift = static_cast<Micros>(static_cast<double>(lease_.lease) * lease_.driftPpm * 1e-6);
    const Micros since = std::max(dead->second, restartedAt_);
    if (now_ > since + lease_.lease + drift + sync::kSecond)
      reportBroken("L2", "a dead site still owns: " + text(record));
  }
  before = record;
}

void Invariants::onServerRestart(const std::vector<PartRecord>& restored) {
  restartedAt_ = now_;
  restored_.clear();
  for (const PartRecord& record : restored) restored_[record.part] = record;
  for (auto& [part, record] : server_) {
    // A crash may lose a grant that no site has received, but no other (S1).
    const auto received = ownerOf_.find({part, record.epoch});
    const auto kept = restored_.find(part);
    const Epoch epoch = kept == restored_.end() ? 0 : kept->second.epoch;
    if (received != ownerOf_.end() && epoch < record.epoch)
      reportBroken("S1", "the journal lost " + text(record));
    record = kept == restored_.end() ? PartRecord{part, kNoSite, 0, {}} : kept->second;
  }
}

void Invariants::finish(const std::vector<std::pair<std::string, double>>& replicaErrors) {
  for (const auto& requests : open_)
    for (const auto& [request, open] : requests)
      if (now_ - open.at > kAnswerLimit)
        reportBroken("L1", "request " + std::to_string(request) + " for part " + std::to_string(open.part) +
                               " unanswered");
  for (const auto& [name, error] : replicaErrors)
    if (error > kReplicaTolerance)
      reportBroken("L4", "replicas of " + name + " differ by " + std::to_string(error) + " m");
}

}  // namespace tandem::client
