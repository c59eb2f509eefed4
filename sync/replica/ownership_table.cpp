#include "sync/replica/ownership_table.h"

#include <algorithm>
#include <limits>
#include <map>
#include <set>

#include "assets/base/assert.h"
#include "sync/replica/co_holder_lists.h"
#include "sync/replica/request_memory.h"

namespace tandem::sync {
namespace {

struct PartEntry {
  PartRecord record;
  Pose atRest;
  bool movable = false;
  bool awaited = false;      // restored with an owner that has not come back yet
  bool hasSequence = false;  // whether a state of this epoch was accepted since the table began
  std::uint32_t sequence = 0;
  Micros leaseFrom = 0;
};

struct SiteEntry {
  std::set<PartId> owned;  // ordered: parts that are freed together are published in this order
};

bool isOlder(const PartRecord& a, const PartRecord& b) {
  if (a.epoch != b.epoch) return a.epoch < b.epoch;
  return a.owner != kNoSite && b.owner == kNoSite;
}

}  // namespace

struct OwnershipTable::State {
  explicit State(std::size_t partCount) : parts(partCount), coHolders(partCount) {}

  std::vector<PartEntry> parts;
  std::map<SiteId, SiteEntry> sites;
  CoHolderLists coHolders;
  RequestMemory answered;
  LeaseRules rules;
  Micros recoveringUntil = std::numeric_limits<Micros>::min();
  std::size_t awaited = 0;
  Epoch floor = 0;  // every new epoch exceeds it

  static constexpr Epoch kLastEpoch = std::numeric_limits<Epoch>::max();
  bool exhausted(const PartEntry& part) const { return std::max(part.record.epoch, floor) == kLastEpoch; }
  void beginEpoch(PartEntry& part) const {
    ASSERT(!exhausted(part));
    part.record.epoch = std::max(part.record.epoch, floor) + 1;
  }

  bool recovering(Micros now) const { return awaited > 0 && now < recoveringUntil; }
  /// Lease expiry as the server counts it: lease + drift since the last ping arrived (L2).
  bool expired(const PartEntry& part, Micros now) const {
    return now - part.leaseFrom >= rules.serverLease();
  }

  void cameBack(PartEntry& part) {
    if (!part.awaited) return;
    ASSERT(awaited > 0);
    part.awaited = false;
    --awaited;
  }
  void own(PartEntry& part, SiteId site, Micros now) {
    ASSERT(site != kNoSite && part.record.part < parts.size());
    part.record.owner = site;
    part.leaseFrom = now;
    part.hasSequence = false;
    sites[site].owned.insert(part.record.part);
  }
  const PartRecord& disown(PartEntry& part) {
    cameBack(part);
    ASSERT(part.record.owner != kNoSite);
    const std::size_t erased = sites[part.record.owner].owned.erase(part.record.part);
    ASSERT(erased == 1);
    part.record.owner = kNoSite;
    part.hasSequence = false;
    return part.record;
  }
  /// Ends an ownership. Where the part has co-holders, the longest one owns it in the next epoch.
  const PartRecord& passOn(PartEntry& part) {
    disown(part);
    const std::optional<SiteId> heir = coHolders.longest(part.record.part);
    if (!heir) return part.record;
    coHolders.remove(part.record.part, *heir);
    if (exhausted(part)) {
      coHolders.removeAll(part.record.part);
      return part.record;
    }
    beginEpoch(part);
    own(part, *heir, coHolders.lastRenewed(*heir));  // its lease runs from its last ping (L2)
    ASSERT(part.record.owner == *heir && !coHolders.contains(part.record.part, *heir));
    return part.record;
  }

  CoHolderRecord coHoldersOf(const PartEntry& part) const {
    return coHolders.record(part.record.part, part.record.epoch);
  }
  /// Answers an Engage or a Disengage: `decide` is asked about parts that exist.
  template <typename Request, typename Decide>
  EngageDecision answer(const Request& request, const Decide& decide) {
    EngageDecision decision;
    decision.reply.request = request.request;
    decision.reply.coHolders.part = request.part;
    if (request.part >= parts.size()) {
      decision.reply.denial = Denial::unknownPart;
      return decision;
    }
    PartEntry& part = parts[request.part];
    decision.reply.denial = decide(part, decision.changed);
    decision.reply.coHolders = coHoldersOf(part);
    return decision;
  }
  Denial decideEngage(SiteId site, Role role, PartEntry& part, Micros now, bool& changed) {
    if (role == Role::observer) return Denial::roleForbids;
    if (!part.movable) return Denial::notMovable;
    if (part.record.owner == kNoSite || part.record.owner == site) return Denial::notOwned;
    if (coHolders.full(part.record.part, site)) return Denial::crowded;
    changed = coHolders.add(part.record.part, site, now);
    return Denial::none;
  }

  /// Decides about the part of a request, or gives the answer that this very request got before (S7).
  template <typename Decide>
  RequestMemory::Answer answerOnce(SiteId site, const RequestMemory::Request& request, bool& repeated,
                                   const Decide& decide) {
    if (const RequestMemory::Answer* earlier = answered.find(site, request)) {
      repeated = true;
      return *earlier;
    }
    RequestMemory::Answer answer;
    answer.record.part = request.part;
    if (request.part >= parts.size()) {
      answer.denial = Denial::unknownPart;
    } else {
      PartEntry& part = parts[request.part];
      answer.denial = decide(part);
      answer.record = part.record;
    }
    answered.remember(site, request, answer);
    return answer;
  }

  Denial decideGrab(SiteId site, Role role, PartEntry& part, Micros now, bool& changed) {
    if (role == Role::observer) return Denial::roleForbids;
    if (!part.movable) return Denial::notMovable;
    // The site owns the part already: it repeats its request, or was restarted.
    if (part.record.owner == site) {
      cameBack(part);
      part.leaseFrom = now;
      return Denial::none;
    }
    if (part.record.owner != kNoSite && !expired(part, now)) return Denial::ownedByOther;
    if (part.record.owner != kNoSite && coHolders.longest(part.record.part)) {
      changed = true;
      return passOn(part).owner == site ? Denial::none : Denial::ownedByOther;
    }
    if (recovering(now)) return Denial::recovering;
    if (exhausted(part)) return Denial::notMovable;
    if (part.record.owner != kNoSite) disown(part);
    ASSERT(!coHolders.longest(part.record.part));  // a part without an owner has no co-holders
    beginEpoch(part);
    own(part, site, now);
    changed = true;
    return Denial::none;
  }
  Denial decideReclaim(SiteId site, Role role, const Reclaim& request, PartEntry& part, Micros now) {
    if (role == Role::observer) return Denial::roleForbids;
    if (part.record.owner != site || part.record.epoch != request.epoch) return Denial::stale;
    cameBack(part);
    part.leaseFrom = now;
    part.record.worldFromPart = request.worldFromPart;
    return Denial::none;
  }
  Denial decideRelease(SiteId site, const Release& request, PartEntry& part, bool& changed) {
    if (part.record.owner != site || part.record.epoch != request.epoch) return Denial::stale;
    part.record.worldFromPart = request.worldFromPart;
    passOn(part);
    changed = true;
    return Denial::none;
  }
};

OwnershipTable::OwnershipTable(std::vector<bool> movable, std::vector<Pose> worldFromPartAtRest,
                               LeaseRules rules)
    : state_(std::make_unique<State>(movable.size())) {
  ASSERT(movable.size() == worldFromPartAtRest.size() && movable.size() <= kMaxParts);
  state_->rules = rules;
  for (std::size_t i = 0; i < movable.size(); ++i) {
    PartEntry& part = state_->parts[i];
    part.movable = movable[i];
    part.atRest = worldFromPartAtRest[i];
    part.record = {static_cast<PartId>(i), kNoSite, 0, worldFromPartAtRest[i]};
  }
}
OwnershipTable::~OwnershipTable() = default;
OwnershipTable::OwnershipTable(OwnershipTable&&) noexcept = default;

void OwnershipTable::restore(std::span<const PartRecord> records, Micros now, Epoch floor) {
  state_->floor = std::max(state_->floor, floor);
  for (const PartRecord& record : records) {
    if (record.part >= state_->parts.size()) continue;
    PartEntry& part = state_->parts[record.part];
    if (isOlder(record, part.record)) continue;
    if (part.record.owner != kNoSite) state_->disown(part);
    part.record = record;
    if (record.owner == kNoSite) continue;
    state_->own(part, record.owner, now);
    part.awaited = true;
    ++state_->awaited;
  }
  state_->recoveringUntil = now + state_->rules.serverLease();
}

OwnershipTable::Decision OwnershipTable::grab(SiteId site, Role role, const Grab& request, Micros now) {
  Decision decision;
  const auto [denial, record] = state_->answerOnce(
      site, {RequestMemory::Kind::grab, request.request, request.part, 0}, decision.repeated,
      [&](PartEntry& part) { return state_->decideGrab(site, role, part, now, decision.changed); });
  decision.reply = {request.request, denial, record};
  return decision;
}

OwnershipTable::Decision OwnershipTable::reclaim(SiteId site, Role role, const Reclaim& request, Micros now) {
  Decision decision;
  const auto [denial, record] = state_->answerOnce(
      site, {RequestMemory::Kind::reclaim, request.request, request.part, request.epoch}, decision.repeated,
      [&](PartEntry& part) { return state_->decideReclaim(site, role, request, part, now); });
  decision.reply = {request.request, denial, record};
  return decision;
}

OwnershipTable::ReleaseDecision OwnershipTable::release(SiteId site, const Release& request) {
  ReleaseDecision decision;
  bool repeated = false;
  const auto [denial, record] = state_->answerOnce(
      site, {RequestMemory::Kind::release, request.request, request.part, request.epoch}, repeated,
      [&](PartEntry& part) { return state_->decideRelease(site, request, part, decision.changed); });
  ASSERT(!(repeated && decision.changed));
  decision.reply = {request.request, denial, record};
  return decision;
}

OwnershipTable::EngageDecision OwnershipTable::engage(SiteId site, Role role, const Engage& request,
                                                      Micros now) {
  return state_->answer(request, [&](PartEntry& part, bool& changed) {
    return state_->decideEngage(site, role, part, now, changed);
  });
}

OwnershipTable::EngageDecision OwnershipTable::disengage(SiteId site, const Disengage& request) {
  return state_->answer(request, [&](PartEntry& part, bool& changed) {
    changed = state_->coHolders.remove(part.record.part, site);
    return Denial::none;
  });
}

CoHolderRecord OwnershipTable::coHolders(PartId id) const {
  ASSERT(id < state_->parts.size());
  return state_->coHoldersOf(state_->parts[id]);
}

bool OwnershipTable::areLinked(PartId id, SiteId a, SiteId b) const {
  ASSERT(id < state_->parts.size());
  const PartEntry& part = state_->parts[id];
  const auto isCoHolder = [&](SiteId site) { return state_->coHolders.contains(id, site); };
  return (part.record.owner == a && isCoHolder(b)) || (part.record.owner == b && isCoHolder(a));
}

std::vector<CoHolderRecord> OwnershipTable::allCoHolders() const {
  std::vector<CoHolderRecord> all;
  for (const PartEntry& part : state_->parts) {
    if (state_->coHolders.longest(part.record.part)) all.push_back(state_->coHoldersOf(part));
  }
  return all;
}

std::vector<CoHolderRecord> OwnershipTable::drainChangedCoHolders() {
  std::vector<CoHolderRecord> changed;
  for (const PartId id : state_->coHolders.drainChanged()) changed.push_back(coHolders(id));
  return changed;
}

std::optional<PartRecord> OwnershipTable::revoke(PartId id) {
  if (id >= state_->parts.size()) return std::nullopt;
  PartEntry& part = state_->parts[id];
  if (part.record.owner == kNoSite || state_->exhausted(part)) return std::nullopt;
  state_->disown(part);
  state_->beginEpoch(part);
  state_->coHolders.removeAll(id);
  return part.record;
}

std::optional<PartRecord> OwnershipTable::withdraw(const PartRecord& grant) {
  if (grant.part >= state_->parts.size()) return std::nullopt;
  state_->answered.forget(grant.owner, grant.part);
  const PartRecord& now = state_->parts[grant.part].record;
  if (now.epoch != grant.epoch || now.owner != grant.owner) return std::nullopt;
  return revoke(grant.part);
}

std::optional<PartRecord> OwnershipTable::reset(PartId id) {
  if (id >= state_->parts.size()) return std::nullopt;
  PartEntry& part = state_->parts[id];
  if (part.record.owner != kNoSite || part.record.epoch == 0 || state_->exhausted(part)) return std::nullopt;
  state_->beginEpoch(part);
  part.record.worldFromPart = part.atRest;
  return part.record;
}

void OwnershipTable::renew(SiteId site, Micros now) {
  state_->coHolders.renew(site, now);
  const auto found = state_->sites.find(site);
  if (found == state_->sites.end()) return;
  for (const PartId id : found->second.owned) state_->parts[id].leaseFrom = now;
}

std::vector<PartRecord> OwnershipTable::leave(SiteId site) {
  std::vector<PartRecord> freed;
  state_->answered.forget(site);
  state_->coHolders.forget(site);
  const auto found = state_->sites.find(site);
  if (found == state_->sites.end()) return freed;
  const std::set<PartId> owned = found->second.owned;
  for (const PartId id : owned) freed.push_back(state_->passOn(state_->parts[id]));
  state_->sites.erase(site);
  return freed;
}

std::vector<PartRecord> OwnershipTable::expire(Micros now) {
  std::vector<PartId> over;
  // Co-holders whose pings stopped are removed first, so that no part passes to one of them.
  state_->coHolders.removeSilent(now, state_->rules.serverLease());
  for (const auto& [site, entry] : state_->sites) {
    for (const PartId id : entry.owned) {
      if (state_->expired(state_->parts[id], now)) over.push_back(id);
    }
  }
  std::sort(over.begin(), over.end());
  std::vector<PartRecord> freed;
  for (const PartId id : over) freed.push_back(state_->passOn(state_->parts[id]));
  return freed;
}

std::optional<Micros> OwnershipTable::nextExpiry() const {
  std::optional<Micros> next;
  for (const auto& [site, entry] : state_->sites) {
    for (const PartId id : entry.owned) {
      const Micros at = state_->parts[id].leaseFrom + state_->rules.serverLease();
      next = next ? std::min(*next, at) : at;
    }
  }
  return next;
}

bool OwnershipTable::accept(SiteId site, const PartState& state) {
  if (state.part >= state_->parts.size()) return false;
  PartEntry& part = state_->parts[state.part];
  if (part.record.owner != site || site == kNoSite || part.record.epoch != state.epoch) return false;
  if (part.hasSequence && state.sequence <= part.sequence) return false;
  part.hasSequence = true;
  part.sequence = state.sequence;
  part.record.worldFromPart = state.worldFromPart;
  state_->cameBack(part);
  return true;
}

const PartRecord& OwnershipTable::part(PartId id) const {
  ASSERT(id < state_->parts.size());
  return state_->parts[id].record;
}

std::vector<PartRecord> OwnershipTable::records() const {
  std::vector<PartRecord> records;
  for (const PartEntry& part : state_->parts) {
    if (part.record.epoch > 0) records.push_back(part.record);
  }
  return records;
}

bool OwnershipTable::recovering(Micros now) const { return state_->recovering(now); }

}  // namespace tandem::sync
