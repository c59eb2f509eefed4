#include "haptics/contact/contact_history.h"

#include <algorithm>
#include <utility>

namespace tandem::haptics {

void ContactHistory::forget(PartId part) {
  const auto end = std::remove_if(contacts_.begin(), contacts_.begin() + contactCount_,
                                  [&](const Contact& k) { return k.first == part || k.other == part; });
  contactCount_ = static_cast<int>(end - contacts_.begin());
  last_->frictionCount = last_->motionCount = 0;
}

void ContactHistory::beginTick(const ContactIsland& all) {
  now_->frictionCount = now_->motionCount = 0;
  for (int k = 0; k < contactCount_; ++k) {
    Contact& contact = contacts_[static_cast<std::size_t>(k)];
    if (all.bodyOf(contact.first) < 0) ++contact.unused;  // asleep, or no longer moved here
  }
}

void ContactHistory::endTick() { std::swap(now_, last_); }

double ContactHistory::lastMotion(PartId part) const {
  double length = 0.0;
  for (int i = 0; i < last_->motionCount; ++i) {
    const Motion& motion = last_->motions[static_cast<std::size_t>(i)];
    if (motion.part == part) length = motion.length;
  }
  return length;
}

void ContactHistory::noteMotion(PartId part, double motion) {
  if (!TICK_ASSERT(fault_, now_->motionCount < kMaxBodies)) return;
  now_->motions[static_cast<std::size_t>(now_->motionCount++)] = {part, motion};
}

bool ContactHistory::isOf(PartId first, PartId other, const ContactIsland& island, int index) {
  const ContactPair& pair = island.pair(index);
  return !pair.isJoint() && pair.other == other && island.first(pair).part == first;
}

void ContactHistory::recallFriction(const ContactIsland& island, ContactSolver& solver) const {
  std::array<FrictionForce, ActiveSet::kMaxRows> known;
  std::size_t count = 0;
  for (int i = 0; i < last_->frictionCount && count < known.size(); ++i) {
    const Friction& last = last_->frictions[static_cast<std::size_t>(i)];
    for (int k = 0; k < island.pairCount(); ++k) {
      if (!isOf(last.first, last.other, island, k)) continue;
      known[count] = last.friction;
      known[count++].source.pair = static_cast<std::uint16_t>(k);
      break;
    }
  }
  solver.recallFriction({known.data(), count});
}

void ContactHistory::noteFriction(const ContactIsland& island, const ContactSolver& solver) {
  for (const FrictionForce& friction : solver.friction()) {
    if (!TICK_ASSERT(fault_, friction.source.pair < island.pairCount())) return;
    if (now_->frictionCount == kMaxFrictions) return;
    const ContactPair& pair = island.pair(friction.source.pair);
    now_->frictions[static_cast<std::size_t>(now_->frictionCount++)] = {island.first(pair).part, pair.other,
                                                                        friction};
  }
}

ContactHistory::Contact& ContactHistory::slot(PartId first, PartId other, const RowSource& source) {
  int oldest = 0;
  for (int k = 0; k < contactCount_; ++k) {
    Contact& contact = contacts_[static_cast<std::size_t>(k)];
    if (contact.first == first && contact.other == other && contact.source.side == source.side &&
        contact.source.sample == source.sample)
      return contact;
    if (contact.unused > contacts_[static_cast<std::size_t>(oldest)].unused) oldest = k;
  }
  return contacts_[static_cast<std::size_t>(contactCount_ < kMaxContacts ? contactCount_++ : oldest)];
}

void ContactHistory::noteContacts(const ContactIsland& island, const ContactRows& rows,
                                  const ContactSolver& solver) {
  for (int k = 0; k < contactCount_; ++k) {
    Contact& contact = contacts_[static_cast<std::size_t>(k)];
    if (island.bodyOf(contact.first) >= 0) ++contact.unused;
  }
  for (const ActiveSet::Row& active : solver.active()) {
    if (!TICK_ASSERT(fault_, active.row >= 0 && active.row < rows.exactRows())) continue;
    RowSource source = rows.exact(active.row).source;
    if (source.sample == assets::kNone) continue;  // of a joint, or of an exit
    if (!TICK_ASSERT(fault_, source.pair < island.pairCount())) continue;
    source.side &= 1;
    const ContactPair& pair = island.pair(source.pair);
    const PartId first = island.first(pair).part;
    slot(first, pair.other, source) = {first, pair.other, source, 0};
  }
  const auto end = std::remove_if(contacts_.begin(), contacts_.begin() + contactCount_,
                                  [](const Contact& contact) { return contact.unused > kCachedSteps; });
  contactCount_ = static_cast<int>(end - contacts_.begin());
}

}  // namespace tandem::haptics
