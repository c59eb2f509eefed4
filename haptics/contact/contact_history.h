#pragma once

// Warm start: what one tick caches for the next, so that resting contacts stay at rest. These are the
// samples of active rows, the friction between two parts, and how far a part moved in its last step.
//
// 1. Entries are known by their parts: the numbers of bodies and pairs differ from tick to tick.
// 2. Free of allocation.

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "haptics/base/fault.h"
#include "haptics/base/fixed_vector.h"
#include "haptics/contact/contact_island.h"
#include "haptics/solver/contact_rows.h"
#include "haptics/solver/contact_solver.h"

namespace tandem::haptics {

class ContactHistory {
 public:
  explicit ContactHistory(FaultLatch& fault) : fault_(fault) {}
  ContactHistory(const ContactHistory&) = delete;
  ContactHistory& operator=(const ContactHistory&) = delete;

  /// Forgets the contacts of a part, and the friction and motion of all parts, when the part begins to move
  /// here.
  void forget(PartId part);

  // A tick: beginTick() with all bodies, then for each island the calls below, then endTick().

  void beginTick(const ContactIsland& all);
  void endTick();

  /// m, the last step of the island in which the part was; 0 if that is not known.
  double lastMotion(PartId part) const;
  void noteMotion(PartId part, double motion);
  /// Gives the solver the friction of the last tick to start from.
  void recallFriction(const ContactIsland& island, ContactSolver& solver) const;
  void noteFriction(const ContactIsland& island, const ContactSolver& solver);
  /// Calls f(source) with each cached sample of the island's pairs: those that had active rows in the last
  /// steps.
  template <typename F>
  void forEachContact(const ContactIsland& island, const F& f) const {
    for (const Contact& contact : contacts_) {
      for (int i = 0; i < island.pairCount(); ++i) {
        if (!isOf(contact.first, contact.other, island, i)) continue;
        RowSource source = contact.source;
        source.pair = static_cast<std::uint16_t>(i);
        f(source);
      }
    }
  }
  /// Remembers the samples of the active rows of a step. Those that have been inactive for kCachedSteps steps
  /// are forgotten.
  void noteContacts(const ContactIsland& island, const ContactRows& rows, const ContactSolver& solver);

 private:
  static constexpr std::size_t kMaxContacts = 48;
  static constexpr int kCachedSteps = 16;
  static constexpr std::size_t kMaxFrictions = 2 * ActiveSet::kMaxRows;

  struct Contact {
    PartId first = kNoPart, other = kNoPart;
    RowSource source;
    int unused = 0;  // steps since its row was last active
  };
  struct Friction {
    PartId first = kNoPart, other = kNoPart;
    FrictionForce friction;
  };
  struct Motion {
    PartId part = kNoPart;
    double length = 0.0;  // m
  };
  struct Tick {
    FixedVector<Friction, kMaxFrictions> frictions;
    FixedVector<Motion, kMaxBodies> motions;

    void clear() {
      frictions.clear();
      motions.clear();
    }
  };

  /// Whether two parts are those of a pair that may touch.
  static bool isOf(PartId first, PartId other, const ContactIsland& island, int pair);
  /// Forgets the contacts for which `ended` is true; the others keep their order.
  template <typename Ended>
  void forgetIf(const Ended& ended) {
    const auto end = std::remove_if(contacts_.begin(), contacts_.end(), ended);
    for (auto left = contacts_.end() - end; left > 0; --left) contacts_.pop_back();
  }
  /// The entry of a contact that is known, else a free entry, else the entry that has been unused for
  /// longest.
  Contact& slot(PartId first, PartId other, const RowSource& source);

  FaultLatch& fault_;
  FixedVector<Contact, kMaxContacts> contacts_;
  std::array<Tick, 2> ticks_;
  Tick* now_ = &ticks_[0];
  Tick* last_ = &ticks_[1];
};

}  // namespace tandem::haptics
