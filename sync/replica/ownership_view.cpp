#include "sync/replica/ownership_view.h"

#include <algorithm>
#include <vector>

#include "assets/base/assert.h"
#include "assets/base/ids.h"

namespace tandem::sync {

struct OwnershipView::State {
  struct Entry {
    PartRecord record;
    bool hasSequence = false;
    std::uint32_t sequence = 0;
    bool unconfirmed = false;  // the lease lapsed after the grant, and no answer has confirmed it since
    bool coHoldingConfirmed = false;  // confirmed by an answer to a request made since the last lapse
    CoHolderRecord coHolders;
  };
  std::vector<Entry> parts;
  LeaseRules rules;
  SiteId self = kNoSite;
  std::uint32_t lapses = 0;
  bool everRenewed = false;
  Micros leaseFrom = 0;
};

OwnershipView::OwnershipView(std::size_t partCount, LeaseRules rules) : state_(std::make_unique<State>()) {
  ASSERT(partCount <= kMaxParts);
  state_->rules = rules;
  state_->parts.resize(partCount);
  for (std::size_t i = 0; i < partCount; ++i)
    state_->parts[i].record.part = state_->parts[i].coHolders.part = static_cast<PartId>(i);
}
OwnershipView::~OwnershipView() = default;
OwnershipView::OwnershipView(OwnershipView&&) noexcept = default;

void OwnershipView::setSelf(SiteId self) { state_->self = self; }
SiteId OwnershipView::self() const { return state_->self; }

bool OwnershipView::apply(const PartRecord& record) {
  if (record.part >= state_->parts.size()) return false;
  State::Entry& entry = state_->parts[record.part];
  const bool newEpoch = record.epoch > entry.record.epoch;
  const bool ends =
      record.epoch == entry.record.epoch && entry.record.owner != kNoSite && record.owner == kNoSite;
  if (!newEpoch && !ends) return false;
  entry.record = record;
  if (newEpoch) {
    entry.hasSequence = false;
    // The server may have ended this ownership long before the record is read, so it counts as unconfirmed. A
    // co-holder to which the part passes was confirmed as co-holder since the last lapse.
    entry.unconfirmed = !entry.coHoldingConfirmed;
    entry.coHoldingConfirmed = false;
  }
  return true;
}

bool OwnershipView::apply(const CoHolderRecord& coHolders) {
  if (coHolders.part >= state_->parts.size()) return false;
  CoHolderRecord& known = state_->parts[coHolders.part].coHolders;
  const bool newer =
      coHolders.epoch != known.epoch ? coHolders.epoch > known.epoch : coHolders.version > known.version;
  if (newer) known = coHolders;
  return newer;
}

void OwnershipView::forgetCoHolders() {
  for (State::Entry& entry : state_->parts) entry.coHolders = {entry.record.part, 0, 0, {}};
}

const CoHolderRecord& OwnershipView::coHolders(PartId part) const {
  ASSERT(part < state_->parts.size());
  return state_->parts[part].coHolders;
}

bool OwnershipView::isCoHolder(PartId part) const {
  const std::vector<SiteId>& sites = coHolders(part).sites;
  return std::find(sites.begin(), sites.end(), state_->self) != sites.end();
}

std::size_t OwnershipView::simulators(PartId part) const {
  return coHolders(part).sites.size() + (state_->parts[part].record.owner != kNoSite ? 1 : 0);
}

OwnershipView::Verdict OwnershipView::accept(SiteId from, const PartState& state) {
  if (state.part >= state_->parts.size()) return Verdict::unknownPart;
  State::Entry& entry = state_->parts[state.part];
  if (from == state_->self) return Verdict::ownPart;
  if (state.epoch < entry.record.epoch) return Verdict::oldEpoch;
  if (state.epoch > entry.record.epoch) return Verdict::futureEpoch;
  if (entry.record.owner == state_->self && state_->self != kNoSite) return Verdict::ownPart;
  if (entry.record.owner != from || from == kNoSite) return Verdict::notOwner;
  if (entry.hasSequence && state.sequence <= entry.sequence) return Verdict::oldSequence;
  entry.hasSequence = true;
  entry.sequence = state.sequence;
  entry.record.worldFromPart = state.worldFromPart;
  return Verdict::accepted;
}

void OwnershipView::renewed(Micros pingSent) {
  if (!state_->everRenewed || pingSent > state_->leaseFrom) state_->leaseFrom = pingSent;
  state_->everRenewed = true;
  ASSERT(state_->leaseFrom >= pingSent);
}

void OwnershipView::renewed(Micros pingSent, Micros received) {
  if (!leaseValid(received)) {
    ++state_->lapses;
    for (State::Entry& entry : state_->parts) {
      entry.unconfirmed = true;
      entry.coHoldingConfirmed = false;
    }
  }
  renewed(pingSent);
}

void OwnershipView::coHoldingConfirmed(PartId part) {
  if (part < state_->parts.size()) state_->parts[part].coHoldingConfirmed = true;
}

std::uint32_t OwnershipView::lapses() const { return state_->lapses; }

bool OwnershipView::needsReclaim(PartId part) const { return owns(part) && state_->parts[part].unconfirmed; }

void OwnershipView::confirmed(PartId part, Epoch epoch) {
  if (part < state_->parts.size() && state_->parts[part].record.epoch == epoch) {
    state_->parts[part].unconfirmed = false;
  }
}

/// The lease as the site counts it: from the sending of the ping, shorter than the server's by drift and
/// margin (S3).
bool OwnershipView::leaseValid(Micros now) const {
  return state_->everRenewed && now - state_->leaseFrom < state_->rules.siteLease();
}

bool OwnershipView::mayPublish(PartId part, Micros now) const {
  return owns(part) && leaseValid(now) && !needsReclaim(part);
}

const PartRecord& OwnershipView::part(PartId part) const {
  ASSERT(part < state_->parts.size());
  return state_->parts[part].record;
}

bool OwnershipView::owns(PartId part) const {
  return part < state_->parts.size() && state_->self != kNoSite &&
         state_->parts[part].record.owner == state_->self;
}

}  // namespace tandem::sync
