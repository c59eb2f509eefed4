#pragma once

// Divides the moving parts of a tick into islands, which cannot influence each other. Each island is solved
// by itself, so that a fast or jammed part does not slow the others.

#include <array>
#include <cstddef>
#include <span>

#include "haptics/base/fault.h"
#include "haptics/contact/contact_island.h"
#include "haptics/contact/moving_part.h"

namespace tandem::haptics {

class Islands {
 public:
  /// `all` holds every part of `moving` as one island, in the same order. `moving` is reordered: parts of one
  /// island stand beside each other, in the order that they had.
  Islands(const ContactIsland& all, std::span<MovingPart*> moving, FaultLatch& fault);

  int count() const { return count_; }
  std::span<MovingPart* const> operator[](int island) const {
    const std::size_t begin = island > 0 ? ends_[static_cast<std::size_t>(island) - 1] : 0;
    return moving_.subspan(begin, ends_[static_cast<std::size_t>(island)] - begin);
  }

 private:
  std::span<MovingPart* const> moving_;
  std::array<std::size_t, kMaxBodies> ends_{};  // where each island ends in moving_
  int count_ = 0;
};

}  // namespace tandem::haptics
