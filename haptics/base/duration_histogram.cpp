#include "haptics/base/duration_histogram.h"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <numeric>

#include "assets/base/assert.h"

namespace tandem::haptics {
namespace {

/// The longest duration of a bucket, in ns.
double upperEdge(int bucket) {
  constexpr int kSub = DurationCounts::kSubBuckets;
  ASSERT(bucket >= 0 && bucket < DurationCounts::kBuckets);
  const int octave = bucket / kSub, sub = bucket % kSub;
  if (octave == 0) return sub;
  return static_cast<double>((static_cast<std::uint64_t>(kSub + sub + 1) << (octave - 1)) - 1);
}

}  // namespace

int DurationCounts::bucketOf(std::int64_t duration_ns) {
  const auto value = static_cast<std::uint64_t>(std::max<std::int64_t>(duration_ns, 0));
  if (value < kSubBuckets) return static_cast<int>(value);
  const int octave = std::bit_width(value) - 4;  // 1 for 16..31
  const int sub = static_cast<int>((value >> (octave - 1)) & (kSubBuckets - 1));
  return std::min(octave * kSubBuckets + sub, kBuckets - 1);
}

std::uint64_t DurationCounts::total() const {
  return std::accumulate(counts.begin(), counts.end(), std::uint64_t{0});
}

double DurationCounts::quantile_ns(double q) const {
  const std::uint64_t all = total();
  if (all == 0) return 0.0;
  const double wanted = std::clamp(q, 0.0, 1.0) * static_cast<double>(all);
  std::uint64_t sum = 0;
  // The last bucket holds all that is longer, too.
  for (int i = 0; i < kBuckets - 1; ++i) {
    sum += counts[static_cast<std::size_t>(i)];
    if (sum > 0 && static_cast<double>(sum) >= wanted)
      return std::min(upperEdge(i), static_cast<double>(max_ns));
  }
  return static_cast<double>(max_ns);
}

DurationCounts DurationCounts::since(const DurationCounts& earlier) const {
  DurationCounts growth = *this;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    if (counts[i] < earlier.counts[i]) return *this;
    growth.counts[i] -= earlier.counts[i];
  }
  return growth;
}

void DurationHistogram::record(std::int64_t duration_ns) {
  auto& slot = counts_[static_cast<std::size_t>(DurationCounts::bucketOf(duration_ns))];
  slot.store(slot.load(std::memory_order_relaxed) + 1,
             std::memory_order_relaxed);  // one writer: no read-modify-write
  if (duration_ns > max_ns_.load(std::memory_order_relaxed))
    max_ns_.store(duration_ns, std::memory_order_relaxed);
}

DurationCounts DurationHistogram::counts() const {
  DurationCounts copy;
  for (std::size_t i = 0; i < copy.counts.size(); ++i)
    copy.counts[i] = counts_[i].load(std::memory_order_relaxed);
  copy.max_ns = max_ns_.load(std::memory_order_relaxed);
  return copy;
}

}  // namespace tandem::haptics
