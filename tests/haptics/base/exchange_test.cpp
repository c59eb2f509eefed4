#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <thread>

#include "haptics/base/device.h"
#include "haptics/base/spsc_ring.h"
#include "haptics/base/triple_buffer.h"

namespace tandem::haptics {
namespace {

/// A value that is torn when its numbers differ.
struct Wide {
  std::array<std::uint64_t, 16> words{};
};

Wide filledWith(std::uint64_t n) {
  Wide wide;
  wide.words.fill(n);
  return wide;
}

TEST(TripleBuffer, GivesTheInitialValueUntilOneIsWritten) {
  TripleBuffer<int> buffer(7);
  int out = 0;
  EXPECT_FALSE(buffer.read(out));
  EXPECT_EQ(out, 7);
  EXPECT_EQ(buffer.latest(), 7);
}

TEST(TripleBuffer, GivesTheLatestOfSeveralWritesOnce) {
  TripleBuffer<int> buffer(0);
  for (int i = 1; i <= 5; ++i) buffer.write(i);
  int out = 0;
  EXPECT_TRUE(buffer.read(out));
  EXPECT_EQ(out, 5);
  EXPECT_FALSE(buffer.read(out));
  EXPECT_EQ(out, 5);
}

TEST(TripleBuffer, HoldsADeviceSample) {
  TripleBuffer<DeviceSample> buffer;
  DeviceSample sample;
  sample.buttons = 3;
  buffer.write(sample);
  EXPECT_EQ(buffer.latest().buttons, 3u);
}

TEST(TripleBuffer, NeverTearsAndNeverGoesBackBetweenTwoThreads) {
  constexpr std::uint64_t kWrites = 200'000;
  TripleBuffer<Wide> buffer(filledWith(0));
  std::thread producer([&buffer] {
    for (std::uint64_t i = 1; i <= kWrites; ++i) buffer.write(filledWith(i));
  });
  std::uint64_t last = 0, torn = 0, backwards = 0;
  while (last < kWrites) {
    const Wide& seen = buffer.latest();
    for (const std::uint64_t word : seen.words) torn += word != seen.words[0];
    backwards += seen.words[0] < last;
    last = seen.words[0];
  }
  producer.join();
  EXPECT_EQ(torn, 0u);
  EXPECT_EQ(backwards, 0u);
}

TEST(SpscRing, RefusesAndCountsWhenFull) {
  SpscRing<int, 4> ring;
  for (int i = 0; i < 4; ++i) EXPECT_TRUE(ring.push(i));
  EXPECT_FALSE(ring.push(4));
  EXPECT_FALSE(ring.push(5));
  EXPECT_EQ(ring.dropped(), 2u);
  EXPECT_EQ(ring.size(), 4u);
  for (int i = 0; i < 4; ++i) {
    int out = -1;
    ASSERT_TRUE(ring.pop(out));
    EXPECT_EQ(out, i);
  }
  int out = -1;
  EXPECT_FALSE(ring.pop(out));
  EXPECT_TRUE(ring.push(6));
  EXPECT_TRUE(ring.pop(out));
  EXPECT_EQ(out, 6);
}

TEST(SpscRing, KeepsOrderAndLosesNothingUncountedBetweenTwoThreads) {
  constexpr std::uint64_t kPushes = 200'000;
  SpscRing<Wide, 64> ring;
  std::atomic<bool> done{false};
  std::uint64_t accepted = 0;
  std::thread producer([&] {
    for (std::uint64_t i = 1; i <= kPushes; ++i) accepted += ring.push(filledWith(i)) ? 1 : 0;
    done.store(true, std::memory_order_release);
  });
  std::uint64_t last = 0, received = 0, wrong = 0;
  Wide out;
  for (;;) {
    const bool finished = done.load(std::memory_order_acquire);
    if (!ring.pop(out)) {
      if (finished) break;
      continue;
    }
    ++received;
    for (const std::uint64_t word : out.words) wrong += word != out.words[0];
    wrong += out.words[0] <= last;
    last = out.words[0];
  }
  producer.join();
  EXPECT_EQ(wrong, 0u);
  EXPECT_EQ(received, accepted);
  EXPECT_EQ(accepted + ring.dropped(), kPushes);
}

}  // namespace
}  // namespace tandem::haptics
