#include "client/simulation/invariants.h"

#include <algorithm>
#include <tuple>

#include <glm/geometric.hpp>

#include "assets/base/assert.h"

namespace tandem::client {

using sync::Micros;
using sync::PartRecord;

namespace {

constexpr Micros kAnswerLimit = 10 * sync::kSecond;  // L1: far above any round trip
/// L2: in which the server notices that a lease is over. What was under way when a site died is known.
constexpr Micros kNoticed = 500 * sync::kMillisecond;
/// R1: for which what a peer was told or has said may be under way after it has gone.
constexpr Micros kInFlight = 4 * sync::kSecond;
/// S3, S8: for which an instructor's command explains that a part is taken from its owner at once.
constexpr Micros kCommanded = 10 * sync::kSecond;
constexpr double kStateTolerance = 1e-4;    // m, S2: the same state, quantised
constexpr double kReplicaTolerance = 1e-5;  // m, L4: a few quanta of the wire

std::string text(const PartRecord& record) {
  return "part " + std::to_string(record.part) + " epoch " + std::to_string(record.epoch) + " owner " +
         std::to_string(record.owner);
}

}  // namespace

const char* toString(Rule rule) {
  constexpr std::array<const char*, kRules> kNames{"S1", "S2", "S3", "S4", "S5", "S6", "S7", "S8", "L1",
                                                   "L2", "L3", "L4", "R1", "R2", "R3", "R4", "R5"};
  return kNames[static_cast<std::size_t>(rule)];
}

Invariants::Invariants(std::size_t sites, sync::LeaseRules lease)
    : lease_(lease), applied_(sites), open_(sites), heardFromTheDead_(sites, 0) {}

void Invariants::setTime(Micros now) {
  ASSERT(now >= now_);
  now_ = now;
}

void Invariants::reportBroken(Rule rule, std::string what) {
  violations_.push_back({toString(rule), sync::toSeconds(now_), std::move(what)});
}

void Invariants::onOwnership(std::size_t site, const PartRecord& record) {
  ASSERT(site < applied_.size());
  AppliedState& applied = applied_[site][record.part];
  if (record.epoch < applied.epoch) reportBroken(Rule::S2, "site took an older ownership: " + text(record));
  if (record.epoch > applied.epoch) applied = {record.epoch, 0};
  checkHandOver(record);
  onTold(record);
}

void Invariants::onTold(const PartRecord& record) {
  if (record.owner == kNoSite) return;
  checked(Rule::S1);
  const auto [entry, fresh] = ownerOf_.emplace(std::pair{record.part, record.epoch}, record.owner);
  if (!fresh && entry->second != record.owner)
    reportBroken(Rule::S1, "two owners in one epoch: " + text(record));
}

/// S6: all sites are told of one pose where an ownership begins or ends.
void Invariants::checkHandOver(const PartRecord& record) {
  if (record.owner != kNoSite) return;  // a record of a running ownership carries its newest pose
  checked(Rule::S6);
  const glm::dvec3& at = record.worldFromPart.position;
  const auto [told, first] =
      handedOver_.try_emplace({record.part, record.epoch, record.owner == kNoSite}, at);
  if (!first && glm::length(told->second - at) > kReplicaTolerance)
    reportBroken(Rule::S6, "two sites were told of different poses: " + text(record));
}

void Invariants::onClockBeyondBound(SiteId self) { beyondBoundAt_[self] = now_; }

void Invariants::onGrab(std::size_t site, const sync::Grab& grab) {
  ASSERT(site < open_.size());
  open_[site][grab.request] = {grab.part, now_};
}

void Invariants::onGrabReply(std::size_t site, const sync::GrabReply& reply) {
  open_[site].erase(reply.request);
  checked(Rule::S7);
  checked(Rule::L1);
  if (reply.denial == sync::Denial::ownedByOther) checked(Rule::S4);
  const auto [entry, fresh] = answers_.emplace(std::pair{site, reply.request}, reply);
  if (!fresh && (entry->second.denial != reply.denial || entry->second.part.epoch != reply.part.epoch))
    reportBroken(Rule::S7, "one request, two answers: " + text(reply.part));
  if (reply.denial == sync::Denial::ownedByOther && reply.part.owner == kNoSite)
    reportBroken(Rule::S4, "denied without a winner: " + text(reply.part));
}

void Invariants::onAccepted(std::size_t site, const sync::PartState& state) {
  ASSERT(site < applied_.size());
  AppliedState& applied = applied_[site][state.part];
  checked(Rule::S2);
  if (state.epoch != applied.epoch)
    reportBroken(Rule::S2, "site applied a state of epoch " + std::to_string(state.epoch) + " in epoch " +
                               std::to_string(applied.epoch) + " of part " + std::to_string(state.part));
  else if (state.sequence <= applied.sequence)
    reportBroken(Rule::S2, "site applied an older state of part " + std::to_string(state.part));
  applied.sequence = std::max(applied.sequence, state.sequence);
  const auto published = published_.find({state.part, state.epoch, state.sequence});
  if (published == published_.end()) return;
  if (glm::length(published->second - state.worldFromPart.position) > kStateTolerance)
    reportBroken(Rule::S2,
                 "site applied a state that nobody published, of part " + std::to_string(state.part));
}

void Invariants::onPublished(SiteId self, const sync::PartState& state) {
  published_[{state.part, state.epoch, state.sequence}] = state.worldFromPart.position;
  // S3: once the server has granted the part to another site, the former owner publishes nothing of it,
  // whether or not it has received word of the grant.
  const auto beyond = beyondBoundAt_.find(self);
  if (beyond != beyondBoundAt_.end() && now_ < beyond->second + 2 * lease_.lease) return;
  if (commandedOf(state.part)) return;
  checked(Rule::S3);
  const auto record = server_.find(state.part);
  if (record != server_.end() && record->second.owner != kNoSite && record->second.epoch > state.epoch &&
      record->second.owner != self)
    reportBroken(Rule::S3, "site " + std::to_string(self) + " still publishes part " +
                               std::to_string(state.part) + " epoch " + std::to_string(state.epoch));
}

/// After a release its owner publishes nothing of the part, so that the server may grant it at once (S8).
void Invariants::onRelease(const sync::Release& release) {
  released_.insert({release.part, release.epoch});
  const auto kept = restored_.find(release.part);
  if (kept != restored_.end() && kept->second.epoch == release.epoch) restored_.erase(kept);
}

void Invariants::onLeft(std::size_t site, SiteId self) {
  std::erase_if(restored_, [&](const auto& entry) { return entry.second.owner == self; });
  onDead(site, self);
}

void Invariants::onCommand(PartId part) {
  restored_.erase(part);
  commandedAt_[part] = now_;
}

/// Whether an instructor has ordered of late that the part be taken from its owner.
bool Invariants::commandedOf(PartId part) const {
  const auto at = commandedAt_.find(part);
  return at != commandedAt_.end() && now_ < at->second + kCommanded;
}

void Invariants::onConnection(std::size_t site, bool up) {
  ASSERT(site < open_.size());
  if (!up)
    open_[site].clear();  // the client answers for the lost connection: it shows the loss to the person
}

void Invariants::onDead(std::size_t site, SiteId self) {
  ASSERT(site < open_.size());
  for (const auto& [request, open] : open_[site]) askerGoneAt_[open.part] = now_;
  open_[site].clear();
  // The client that starts in its place is another site: it numbers its requests, and receives states, anew.
  answers_.erase(answers_.lower_bound({site, 0}), answers_.lower_bound({site + 1, 0}));
  applied_[site].clear();
  if (self != kNoSite) dead_[self] = {site, now_};
}

void Invariants::onHeardFromTheDead(std::size_t site, Micros at) {
  ASSERT(site < heardFromTheDead_.size());
  heardFromTheDead_[site] = at;
}

void Invariants::onServerRecord(const PartRecord& record) {
  PartRecord& before = server_[record.part];
  checkDead(record);
  if (record.epoch == before.epoch && record.owner == before.owner) return;
  if (record.epoch < before.epoch) reportBroken(Rule::S1, "the server's epoch went back: " + text(record));
  const bool granted = record.owner != kNoSite && record.epoch > before.epoch;
  if (granted) {
    grants_.push_back({sync::toSeconds(now_), record.part, record.owner, record.epoch});
    const auto kept = restored_.find(record.part);
    const bool early = restartedAt_ >= 0 && now_ < restartedAt_ + lease_.lease;
    if (early) checked(Rule::S8);
    if (early && kept != restored_.end() && kept->second.owner != kNoSite &&
        kept->second.owner != record.owner)
      reportBroken(Rule::S8, "granted while an earlier owner may still hold it: " + text(record));
  }
  // An ownership ends in its epoch. Only a command takes the part away with a new one (R1), unless that was
  // an heir's who gave it back at once: finish() knows of who was told, heirIsGone() of who had left.
  if (before.owner != kNoSite && record.owner == kNoSite && record.epoch == before.epoch + 1) {
    checked(Rule::R1);
    // A server that can write again takes back the grants that it had to deny meanwhile.
    const bool writesAgain = hinderedAt_ >= 0 && now_ < hinderedAt_ + sync::kSecond;
    const bool strangersAbout = strangerAt_ >= 0 && now_ < strangerAt_ + kInFlight;  // are told, and gone
    if (!commandedOf(record.part) && !writesAgain && !strangersAbout && !heirIsGone(before))
      takenAway_.push_back({record.part, record.epoch});
  }
  before = record;
}

/// Whether the owner gave the part up and somebody else, or the same site, had asked for it and has gone
/// since, so that the server may have granted it and freed it in one step.
bool Invariants::heirIsGone(const PartRecord& owned) const {
  const auto asker = askerGoneAt_.find(owned.part);
  if (asker == askerGoneAt_.end() || now_ > asker->second + kInFlight) return false;
  return released_.contains({owned.part, owned.epoch}) || dead_.contains(owned.owner);
}

/// L2: a part of a dead site is free after the lease and the drift of clocks. A restart begins a new lease.
void Invariants::checkDead(const PartRecord& record) {
  const auto dead = dead_.find(record.owner);
  if (dead == dead_.end()) return;
  checked(Rule::L2);
  const auto drift = static_cast<Micros>(static_cast<double>(lease_.lease) * lease_.driftPpm * 1e-6);
  const Micros since =
      std::max({dead->second.since, heardFromTheDead_[dead->second.site], restartedAt_, hinderedAt_});
  if (now_ <= since + lease_.lease + drift + kNoticed) return;
  reportBroken(Rule::L2, "a dead site still owns: " + text(record));
  dead_.erase(dead);
}

void Invariants::onServerCoHolders(const std::vector<sync::CoHolderRecord>& lists) {
  for (const sync::CoHolderRecord& list : lists) {
    checked(Rule::S5);
    const PartRecord& record = server_[list.part];
    if (record.owner == kNoSite) reportBroken(Rule::S5, "simulated, but without an owner: " + text(record));
    const std::set<SiteId> sites(list.sites.begin(), list.sites.end());
    if (sites.size() != list.sites.size() || sites.contains(record.owner))
      reportBroken(Rule::S5, "a co-holder twice, or the owner too: " + text(record));
  }
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
      reportBroken(Rule::S1, "the journal lost " + text(record));
    record = kept == restored_.end() ? PartRecord{part, kNoSite, 0, {}} : kept->second;
  }
}

void Invariants::finish(const std::vector<std::pair<std::string, double>>& replicaErrors) {
  checked(Rule::L4);
  for (const auto& taken : takenAway_)
    if (!ownerOf_.contains(taken))
      reportBroken(Rule::R1, "part " + std::to_string(taken.first) +
                                 " was taken away by nobody's command, epoch " +
                                 std::to_string(taken.second));
  for (const auto& requests : open_)
    for (const auto& [request, open] : requests)
      if (now_ - open.at > kAnswerLimit)
        reportBroken(Rule::L1, "request " + std::to_string(request) + " for part " +
                                   std::to_string(open.part) + " unanswered");
  for (const auto& [name, error] : replicaErrors)
    if (error > kReplicaTolerance)
      reportBroken(Rule::L4, "replicas of " + name + " differ by " + std::to_string(error) + " m");
}

}  // namespace tandem::client
