#pragma once

// Two parts whose overlap is measured.

#include "haptics/touch/sample_touch.h"

namespace tandem::haptics {

/// A part that begins to move here, and another one, as they stand.
struct PartPair {
  const PartModel* first = nullptr;  // the part that begins to move
  const PartModel* other = nullptr;
  Pose otherFromFirst;  // part frames

  /// The samples of one of them before the other.
  SampledModels side(bool ofFirst) const {
    if (ofFirst) return {first, other, otherFromFirst};
    return {other, first, inverse(otherFromFirst)};
  }
};

}  // namespace tandem::haptics
