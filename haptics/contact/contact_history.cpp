#include "haptics/contact/contact_history.h"

#include <utility>

namespace tandem::haptics {

void ContactHistory::forget(PartId part) {
  forgetIf([&](const Contact& k) { return k.first == part || k.other == part; });
  last_->clear();
}

void ContactHistory::beginTick(const ContactIsland& all) {
  now_->clear();
  for (Contact& contact : contacts_) {
    if (all.bodyOf(contact.first) < 0) ++contact.unused;  // asleep, or no longer moved here
  }
}

void ContactHistory::endTick() { std::swap(now_, last_); }

double ContactHistory::lastMotion(PartId part) const {
  double length = 0.0;
  for (const Motion& motion : last_->motions) {
    if (motion.part == part) length = motion.length;
  }
  return length;
}

void ContactHistory::noteMotion(PartId part, double motion) {
  if (!TICK_ASSERT(fault_, !now_->motions.full())) return;
  now_->motions.push_back({part, motion});
}

bool ContactHistory::isOf(PartId first, PartId other, const ContactIsland& island, int index) {
  const ContactPair& pair = island.pair(index);
  return pair.mayTouch() && pair.other == other && island.first(pair).part == first;
}

void ContactHistory::recallFriction(const ContactIsland& island, ContactSolver& solver) const {
  FixedVector<FrictionForce, ActiveSet::kMaxRows> known;
  for (const Friction& last : last_->frictions) {
    if (known.full()) break;
    for (int k = 0; k < island.pairCount(); ++k) {
      if (!isOf(last.first, last.other, island, k)) continue;
      known.push_back(last.friction).source.pair = static_cast<std::uint16_t>(k);
      break;
    }
  }
  solver.recallFriction({known.data(), known.size()});
}

void ContactHistory::noteFriction(const ContactIsland& island, const ContactSolver& solver) {
  for (const FrictionForce& friction : solver.friction()) {
    if (!TICK_ASSERT(fault_, friction.source.pair < island.pairCount())) return;
    if (now_->frictions.full()) return;
    const ContactPair& pair = island.pair(friction.source.pair);
    now_->frictions.push_back({island.first(pair).part, pair.other, friction});
  }
}

ContactHistory::Contact& ContactHistory::slot(PartId first, PartId other, const RowSource& source) {
  Contact* oldest = contacts_.data();
  for (Contact& contact : contacts_) {
    if (contact.first == first && contact.other == other && contact.source.side == source.side &&
        contact.source.sample == source.sample)
      return contact;
    if (contact.unused > oldest->unused) oldest = &contact;
  }
  return contacts_.full() ? *oldest : contacts_.push_back({});
}

void ContactHistory::noteContacts(const ContactIsland& island, const ContactRows& rows,
                                  const ContactSolver& solver) {
  for (Contact& contact : contacts_) {
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
  forgetIf([](const Contact& contact) { return contact.unused > kCachedSteps; });
}

}  // namespace tandem::haptics
