#include "haptics/servo/servo_schedule.h"

#include <algorithm>
#include <array>
#include <bit>

#include "assets/base/assert.h"

namespace tandem::haptics {

ServoSchedule::ServoSchedule(std::int64_t start_ns, std::int64_t period_ns)
    : period_ns_(period_ns), deadline_ns_(start_ns + period_ns) {
  ASSERT(period_ns > 0);
}

std::int64_t ServoSchedule::advance(std::int64_t done_ns) {
  deadline_ns_ += period_ns_;
  if (done_ns <= deadline_ns_) return 0;
  // The first grid point that is not yet over; a burst of catch-up ticks would send outdated forces to the
  // device.
  const std::int64_t skipped = (done_ns - deadline_ns_ + period_ns_ - 1) / period_ns_;
  ASSERT(skipped > 0);
  deadline_ns_ += skipped * period_ns_;
  return skipped;
}

bool OverrunGuard::note(bool overran) {
  history_ = (history_ << 1) | (overran ? 1u : 0u);
  if (std::popcount(history_) >= kLimit) tripped_ = true;
  if (history_ == 0) tripped_ = false;
  return tripped_;
}

void EffortGuard::note(double share) {
  history_ = (history_ << 1) | (share > kShort ? 1u : 0u);
  calm_ = share < kEasy ? calm_ + 1 : 0;
  if (std::popcount(history_) >= kLimit) {
    stage_ = std::min(stage_ + 1, kMaxStages);
    history_ = 0;  // the next stage is judged by its own ticks
    calm_ = 0;
  } else if (calm_ >= kCalm) {
    stage_ = std::max(stage_ - 1, 0);
    calm_ = 0;
  }
}

ContactEffort EffortGuard::limited(ContactEffort set) const {
  ASSERT(stage_ >= 0 && stage_ <= kMaxStages);
  constexpr std::array<int, kMaxStages + 1> kMaxSteps = {4, 4, 2, 1};
  return {std::min(set.steps, kMaxSteps[static_cast<std::size_t>(stage_)]), set.sampleQueries >> stage_,
          set.exact, set.descend && stage_ == 0};
}

}  // namespace tandem::haptics
