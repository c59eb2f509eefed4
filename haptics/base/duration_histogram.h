#pragma once

// How often each duration occurred: a histogram that one thread fills while others read it, and copies of it,
// whose difference is the histogram of a period.

#include <array>
#include <atomic>
#include <cstdint>

namespace tandem::haptics {

/// Durations from 0 to about 1 s in buckets of 1/16 of an octave (6 % wide).
struct DurationCounts {
  static constexpr int kSubBuckets = 16, kOctaves = 27;
  static constexpr int kBuckets = kSubBuckets * kOctaves;

  std::array<std::uint64_t, kBuckets> counts{};
  std::int64_t max_ns = 0;  // no duration is longer

  static int bucketOf(std::int64_t duration_ns);
  std::uint64_t total() const;
  /// The duration in ns that a share `q` in [0, 1] of the records does not exceed, to one bucket; 0 when
  /// empty.
  double quantile_ns(double q) const;
  /// What was recorded after the copy `earlier` was taken. All of it if a histogram was begun anew since.
  DurationCounts since(const DurationCounts& earlier) const;
};

/// One thread records, any thread reads.
class DurationHistogram {
 public:
  void record(std::int64_t duration_ns);
  DurationCounts counts() const;

 private:
  std::array<std::atomic<std::uint64_t>, DurationCounts::kBuckets> counts_{};
  std::atomic<std::int64_t> max_ns_{0};
};

}  // namespace tandem::haptics
