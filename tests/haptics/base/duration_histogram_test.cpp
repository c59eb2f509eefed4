#include "haptics/base/duration_histogram.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

namespace tandem::haptics {
namespace {

TEST(DurationHistogram, GivesQuantilesWithinOneBucket) {
  DurationHistogram histogram;
  EXPECT_EQ(histogram.counts().quantile_ns(0.5), 0.0);
  for (int i = 1; i <= 10000; ++i) histogram.record(i * 100);
  const DurationCounts counts = histogram.counts();
  EXPECT_EQ(counts.total(), 10000u);
  EXPECT_EQ(counts.max_ns, 1'000'000);
  for (const double q : {0.01, 0.5, 0.9, 0.99}) {
    EXPECT_GE(counts.quantile_ns(q), q * 1e6 * 0.999) << q;
    EXPECT_LE(counts.quantile_ns(q), q * 1e6 * 1.07) << q;
  }
  EXPECT_EQ(counts.quantile_ns(1.0), 1e6);
}

TEST(DurationHistogram, TakesEveryDuration) {
  DurationHistogram histogram;
  constexpr std::int64_t kLongest = std::numeric_limits<std::int64_t>::max();
  for (const std::int64_t duration : {std::int64_t{-5}, std::int64_t{0}, std::int64_t{15}, std::int64_t{16},
                                      std::int64_t{1} << 40, kLongest})
    histogram.record(duration);
  EXPECT_EQ(histogram.counts().total(), 6u);
  EXPECT_EQ(histogram.counts().quantile_ns(0.0), 0.0);
  EXPECT_EQ(histogram.counts().quantile_ns(1.0), static_cast<double>(kLongest));
}

TEST(DurationHistogram, OfAPeriodKnowsNothingOfWhatWasBefore) {
  for (unsigned seed = 0; seed < 50; ++seed) {
    std::mt19937 random(seed);
    DurationHistogram histogram;
    DurationCounts before;
    for (int period = 0; period < 8; ++period) {
      const auto most = std::int64_t{1} << (7 + random() % 22);  // up to 0.5 s
      std::vector<std::int64_t> drawn(1 + random() % 900);
      for (auto& duration : drawn) {
        duration = 1 + static_cast<std::int64_t>(random()) % most;
        histogram.record(duration);
      }
      std::sort(drawn.begin(), drawn.end());
      const DurationCounts now = histogram.counts(), grown = now.since(before);
      before = now;
      ASSERT_EQ(grown.total(), drawn.size());
      for (const double q : {0.5, 0.99, 1.0}) {
        const auto rank = static_cast<std::size_t>(std::ceil(q * static_cast<double>(drawn.size())));
        const auto exact = static_cast<double>(drawn[std::max<std::size_t>(rank, 1) - 1]);
        EXPECT_GE(grown.quantile_ns(q), exact) << "seed " << seed << ", share " << q;
        EXPECT_LE(grown.quantile_ns(q), exact * 1.07) << "seed " << seed << ", share " << q;
      }
    }
    EXPECT_EQ(histogram.counts().since(before).quantile_ns(1.0), 0.0) << "a period without a tick";
  }
}

TEST(DurationHistogram, ThatWasBegunAnewIsTakenWhole) {
  DurationHistogram first, second;
  for (int i = 0; i < 10; ++i) first.record(1000);
  second.record(5000);
  const DurationCounts grown = second.counts().since(first.counts());
  EXPECT_EQ(grown.total(), 1u);
  EXPECT_EQ(grown.quantile_ns(1.0), 5000.0);
}

}  // namespace
}  // namespace tandem::haptics
