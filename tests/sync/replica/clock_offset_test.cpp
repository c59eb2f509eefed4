#include "sync/replica/clock_offset.h"

#include <gtest/gtest.h>

#include "tests/sync/wire/random_messages.h"

namespace tandem::sync {
namespace {

TEST(ClockOffset, IsLocalTimeBeforeTheFirstPong) {
  ClockOffset clock;
  EXPECT_FALSE(clock.known());
  EXPECT_EQ(clock.sessionTime(123), 123);
}

TEST(ClockOffset, UsesTheFirstPongAtOnce) {
  ClockOffset clock;
  clock.observe(1000, 501000, 3000);
  EXPECT_TRUE(clock.known());
  EXPECT_EQ(clock.sessionTime(3000), 502000);
  EXPECT_EQ(clock.bestRoundTrip(), 2000);
}

TEST(ClockOffset, IgnoresAPongFromTheFuture) {
  ClockOffset clock;
  clock.observe(5000, 0, 4000);
  EXPECT_FALSE(clock.known());
}

/// Delays of uplink and downlink with one-sided jitter, and a local clock that is `ppm` fast: the error bound
/// of the header must hold.
TEST(ClockOffset, StaysWithinHalfTheBestRoundTripUnderAsymmetricJitter) {
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    testing::RandomMessages random(seed);
    ClockOffset clock;
    const double ppm = random.real(-50.0, 50.0);
    const Micros ahead = static_cast<Micros>(random.real(-1e9, 1e9));
    const auto localAt = [&](Micros trueTime) {
      return trueTime + ahead + static_cast<Micros>(static_cast<double>(trueTime) * ppm * 1e-6);
    };
    Micros last = std::numeric_limits<Micros>::min();
    for (Micros t = 0; t < 60 * kSecond; t += 250 * kMillisecond) {
      const auto up = static_cast<Micros>(10000 + 40000 * random.real(0, 1) * random.real(0, 1));
      const auto down = static_cast<Micros>(12000 + 5000 * random.real(0, 1));
      clock.observe(localAt(t), t + up, localAt(t + up + down));
      for (Micros s = t + up + down; s < t + 250 * kMillisecond; s += 7 * kMillisecond) {
        const Micros estimate = clock.sessionTime(localAt(s));
        EXPECT_GE(estimate, last) << "monotonic";
        last = estimate;
        const double bound = 0.5 * static_cast<double>(clock.bestRoundTrip()) + 100e-6 * 16 * 250000 + 2;
        if (t > 10 * kSecond) {
          EXPECT_LE(std::abs(static_cast<double>(estimate - s)), bound) << "seed " << seed;
        }
      }
    }
  }
}

/// Session time of a clock that is right at local time 0 and, from then on, told to be off by `step`.
ClockOffset steppedBy(Micros step) {
  ClockOffset clock;
  clock.observe(0, 0, 0);
  clock.sessionTime(0);
  for (int i = 1; i <= 16; ++i) clock.observe(i, i + step, i);
  return clock;
}

TEST(ClockOffset, SlewsAfterAStepInsteadOfJumping) {
  for (const Micros step : {40 * kMillisecond, -40 * kMillisecond}) {
    ClockOffset clock = steppedBy(step);
    Micros last = clock.sessionTime(0);
    for (Micros t = 1000; t <= 3 * kSecond; t += 1000) {
      const Micros now = clock.sessionTime(t);
      EXPECT_GE(now - last, 980 - 1);
      EXPECT_LE(now - last, 1020 + 1);
      last = now;
    }
    EXPECT_EQ(last, 3 * kSecond + step);
    EXPECT_LE(clock.sessionTime(2 * kSecond), last) << "an earlier local time";
  }
}

TEST(ClockOffset, RecoversWithinSecondsFromAClockThatRanFarOff) {
  for (const Micros step : {-2 * kSecond, kSecond, 100 * kSecond}) {
    ClockOffset clock = steppedBy(step);
    Micros last = clock.sessionTime(0);
    for (Micros t = 1000; t <= 10 * kSecond; t += 1000) {
      const Micros now = clock.sessionTime(t);
      EXPECT_GE(now - last, 500 - 1);
      EXPECT_LE(now - last, 1500 + 1);
      last = now;
    }
    if (std::abs(step) > 10 * kSecond) continue;  // it catches up half a second in each second
    EXPECT_LE(std::abs(last - 10 * kSecond - step), 50 * kMillisecond);
  }
}

TEST(ClockOffset, ForgetsOnReset) {
  ClockOffset clock;
  clock.observe(0, 5000, 10);
  clock.sessionTime(20);
  clock.reset();
  EXPECT_FALSE(clock.known());
  clock.observe(100, 50, 100);
  EXPECT_EQ(clock.sessionTime(100), 50);
}

}  // namespace
}  // namespace tandem::sync
