#pragma once

// The fronts of the parts that were swept last; see sweep_front.h.

#include <array>
#include <cstddef>

#include "assets/base/ids.h"
#include "haptics/geometry/sweep_front.h"

namespace tandem::haptics {

class SweepFronts {
 public:
  /// The front of a part; it replaces that of the part asked for longest ago.
  SweepFront& of(PartId part) {
    if (entries_[last_].part == part) return entries_[last_].front;
    last_ = 1 - last_;
    Entry& entry = entries_[last_];
    if (entry.part != part) entry.front.forget();
    entry.part = part;
    return entry.front;
  }
  /// Some mesh has changed or gone.
  void forget() {
    for (Entry& entry : entries_) entry.front.forget();
  }
  /// For tests: see SweepFront::exaggerate().
  void exaggerate(float by) {
    for (Entry& entry : entries_) entry.front.exaggerate(by);
  }

 private:
  struct Entry {
    PartId part = kNoPart;
    SweepFront front;
  };

  std::array<Entry, 2> entries_;
  std::size_t last_ = 0;
};

}  // namespace tandem::haptics
