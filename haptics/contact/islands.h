#pragma once

// Divides the moving parts of a tick into islands, which cannot influence each other. Each island is solved
// by itself, so that a fast or jammed part does not slow the others.

#include <cstddef>
#include <span>

#include "haptics/base/fault.h"
#include "haptics/base/fixed_vector.h"
#include "haptics/contact/contact_island.h"
#include "haptics/contact/moving_part.h"

namespace tandem::haptics {

class Islands {
 public:
  /// `all` holds every part of `moving` as one island, in the same order. `moving` is reordered: parts of one
  /// island stand beside each other, in the order that they had.
  Islands(const ContactIsland& all, std::span<MovingPart*> moving, FaultLatch& fault);

  int count() const { return static_cast<int>(ends_.size()); }
  std::span<MovingPart* const> operator[](int island) const {
    const auto at = static_cast<std::size_t>(island);
    const std::size_t begin = at > 0 ? ends_[at - 1] : 0;
    return moving_.subspan(begin, ends_[at] - begin);
  }

 private:
  std::span<MovingPart* const> moving_;
  FixedVector<std::size_t, kMaxBodies> ends_;  // where each island ends in moving_
};

}  // namespace tandem::haptics
