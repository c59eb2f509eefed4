#include "client/session/pings.h"

#include <gtest/gtest.h>

namespace tandem::client {
namespace {

using namespace sync;

TEST(Pings, AreDueAtOnceAndThenAtTheInterval) {
  SessionClock clock;
  clock.advance(kSecond);
  Pings pings(100 * kMillisecond, clock);
  pings.reset();
  ASSERT_TRUE(pings.due());
  EXPECT_EQ(pings.next(0).siteTime, kSecond);
  clock.advance(kSecond + 99 * kMillisecond);
  EXPECT_FALSE(pings.due());
  clock.advance(kSecond + 100 * kMillisecond);
  EXPECT_TRUE(pings.due());
}

TEST(Pings, AnswersSetTheClockAndTheRoundTrip) {
  SessionClock clock;
  clock.advance(kSecond);
  Pings pings(100 * kMillisecond, clock);
  pings.reset();
  const Ping ping = pings.next(0);
  clock.advance(kSecond + 20 * kMillisecond);
  EXPECT_TRUE(pings.observe({ping.sequence, ping.siteTime, 7 * kSecond, 0}));
  EXPECT_DOUBLE_EQ(pings.roundTrip_ms(), 20.0);
  EXPECT_EQ(clock.time(), 7 * kSecond + 10 * kMillisecond);  // half of the round trip after the server's time
}

TEST(Pings, AnswersFromTheFutureOrFromLongAgoChangeNothing) {
  SessionClock clock;
  clock.advance(kSecond);
  Pings pings(100 * kMillisecond, clock);
  pings.reset();
  EXPECT_FALSE(pings.observe({0, kSecond + 1, 7 * kSecond, 0}));
  clock.advance(2 * kSecond + Pings::kMaxPongAge);
  EXPECT_FALSE(pings.observe({0, kSecond, 7 * kSecond, 0}));
  EXPECT_FALSE(clock.known());
  EXPECT_EQ(pings.roundTrip_ms(), 0.0);
}

TEST(Pings, UplinkLossStandsBesideTheCountOfTheNewestPing) {
  SessionClock clock;
  clock.advance(kSecond);
  Pings pings(kMillisecond, clock);
  pings.reset();
  const Ping first = pings.next(10);
  EXPECT_TRUE(
      pings.observe({first.sequence, first.siteTime, 0, 10}));  // counting begins with the first arrival
  clock.advance(2 * kSecond);
  const Ping second = pings.next(20);
  EXPECT_TRUE(pings.observe({second.sequence, second.siteTime, 0, 15}));
  EXPECT_DOUBLE_EQ(pings.lossUp(), 0.5);
  clock.advance(3 * kSecond);
  const Ping third = pings.next(40);
  EXPECT_TRUE(pings.observe({second.sequence, second.siteTime, 0, 20}));  // an older answer counts no loss
  EXPECT_DOUBLE_EQ(pings.lossUp(), 0.5);
  EXPECT_TRUE(pings.observe({third.sequence, third.siteTime, 0, 40}));
  EXPECT_DOUBLE_EQ(pings.lossUp(), 0.0);
}

/// Sends a ping every 100 ms for `seconds`.
void pingFor(double seconds, SessionClock& clock, Pings& pings) {
  for (const Micros end = clock.now() + static_cast<Micros>(1e6 * seconds); clock.now() < end;) {
    clock.advance(clock.now() + 100 * kMillisecond);
    static_cast<void>(pings.next(0));
  }
}

TEST(Pings, AServerThatAnswersNoneIsSilentWithinTwoSeconds) {
  SessionClock clock;
  clock.advance(kSecond);
  Pings pings(100 * kMillisecond, clock);
  pings.reset();
  pingFor(1.6, clock, pings);
  EXPECT_FALSE(pings.serverIsSilent());
  EXPECT_TRUE(pings.observe({1, clock.now() - kSecond, 7 * kSecond, 0}));  // a late answer is one
  pingFor(1.6, clock, pings);
  EXPECT_FALSE(pings.serverIsSilent());
  pingFor(0.2, clock, pings);
  EXPECT_TRUE(pings.serverIsSilent());
  pings.reset();
  EXPECT_FALSE(pings.serverIsSilent());
}

TEST(Pings, ASiteThatStoodStillItselfDoesNotBlameTheServer) {
  SessionClock clock;
  clock.advance(kSecond);
  Pings pings(100 * kMillisecond, clock);
  pings.reset();
  static_cast<void>(pings.next(0));
  clock.advance(60 * kSecond);
  pingFor(0.2, clock, pings);
  EXPECT_FALSE(pings.serverIsSilent());
}

}  // namespace
}  // namespace tandem::client
