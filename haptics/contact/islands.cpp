#include "haptics/contact/islands.h"

#include <algorithm>
#include <array>

namespace tandem::haptics {

Islands::Islands(const ContactIsland& all, std::span<MovingPart*> moving, FaultLatch& fault)
    : moving_(moving) {
  const auto count = static_cast<std::size_t>(all.bodyCount());
  if (!TICK_ASSERT(fault, count == moving.size())) return;
  std::array<int, kMaxBodies> island;  // of each body: the lowest body of its island
  for (std::size_t i = 0; i < count; ++i) island[i] = static_cast<int>(i);
  for (const ContactPair& pair : all.pairs()) {
    if (pair.second < 0) continue;
    const int a = island[static_cast<std::size_t>(pair.first)],
              b = island[static_cast<std::size_t>(pair.second)];
    std::replace(island.begin(), island.begin() + all.bodyCount(), std::max(a, b), std::min(a, b));
  }
  std::array<MovingPart*, kMaxBodies> before;
  std::copy(moving.begin(), moving.end(), before.begin());
  std::size_t next = 0;
  for (int i = 0; i < all.bodyCount(); ++i) {
    if (island[static_cast<std::size_t>(i)] != i) continue;
    for (std::size_t k = 0; k < count; ++k) {
      if (island[k] == i) moving[next++] = before[k];
    }
    ends_.push_back(next);
  }
  TICK_ASSERT(fault, next == count);
}

}  // namespace tandem::haptics
