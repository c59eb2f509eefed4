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
          set.exact};
}

int DurationHistogram::bucketOf(std::int64_t duration_ns) {
  const auto value = static_cast<std::uint64_t>(std::max<std::int64_t>(duration_ns, 0));
  if (value < kSubBuckets) return static_cast<int>(value);
  const int octave = std::bit_width(value) - 4;  // 1 for 16..31
  const int sub = static_cast<int>((value >> (octave - 1)) & (kSubBuckets - 1));
  return std::min(octave * kSubBuckets + sub, kBuckets - 1);
}

double DurationHistogram::upperEdge(int bucket) {
  ASSERT(bucket >= 0 && bucket < kBuckets);
  const int octave = bucket / kSubBuckets, sub = bucket % kSubBuckets;
  if (octave == 0) return sub;
  return static_cast<double>((static_cast<std::uint64_t>(kSubBuckets + sub + 1) << (octave - 1)) - 1);
}

void DurationHistogram::record(std::int64_t duration_ns) {
  auto& slot = counts_[static_cast<std::size_t>(bucketOf(duration_ns))];
  slot.store(slot.load(std::memory_order_relaxed) + 1,
             std::memory_order_relaxed);  // one writer: no read-modify-write
  if (duration_ns > max_ns_.load(std::memory_order_relaxed))
    max_ns_.store(duration_ns, std::memory_order_relaxed);
}

std::uint64_t DurationHistogram::count() const {
  std::uint64_t sum = 0;
  for (const auto& slot : counts_) sum += slot.load(std::memory_order_relaxed);
  return sum;
}

double DurationHistogram::quantile_ns(double q) const {
  const std::uint64_t total = count();
  if (total == 0) return 0.0;
  const double wanted = std::clamp(q, 0.0, 1.0) * static_cast<double>(total);
  std::uint64_t sum = 0;
  for (int i = 0; i < kBuckets; ++i) {
    sum += counts_[static_cast<std::size_t>(i)].load(std::memory_order_relaxed);
    if (sum > 0 && static_cast<double>(sum) >= wanted)
      return std::min(upperEdge(i), static_cast<double>(max_ns()));
  }
  return static_cast<double>(max_ns());
}

}  // namespace tandem::haptics
