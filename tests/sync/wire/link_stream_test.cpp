#include "sync/wire/link_stream.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "sync/wire/wire.h"

namespace tandem::sync {
namespace {

constexpr Micros kLinkPeriod = 4 * kMillisecond;

/// A part that is led to and fro for minutes under a steady force, so that sums exceed the range of their low
/// bits many times.
LinkState stateAt(std::uint32_t sequence) {
  const double t = 0.004 * sequence, phase = 2.0 * t;
  LinkState state;
  state.epoch = 7;
  state.sequence = sequence;
  state.time = 40 * kSecond + sequence * kLinkPeriod;
  for (std::size_t i = 0; i < 6; ++i)
    state.wave[i] = (i % 2 == 0 ? 2.7 : -1.1) * t + 0.3 * std::sin(phase + static_cast<double>(i));
  state.energy = 3.7 * t;
  state.fade = std::min(1.0, t);
  state.on = sequence > 3;
  state.asks = sequence % 5 == 0;
  state.regime = static_cast<std::uint8_t>(sequence / 100 % 3);
  state.worldFromDrawn.position = {0.05 * std::sin(phase), 0.1, -0.2};
  state.worldFromDrawn.orientation = fromRotationVector({0.0, 0.0, 0.4 * std::sin(phase)});
  state.twist.linear = {0.1 * std::cos(phase), 0.0, 0.0};
  state.twist.angular = {0.0, 0.0, 0.8 * std::cos(phase)};
  return state;
}

LinkUpdate onTheWire(const LinkState& state) {
  const WireFrame frame;
  std::vector<std::byte> bytes;
  StateMessage message;
  encodeState(toWire(state, 3, 5), frame, bytes);
  const bool posed = !state.on || state.sequence <= 8 || state.sequence % 8 == 1;
  EXPECT_EQ(bytes.size(), posed ? 70u : 39u);
  EXPECT_TRUE(decodeState(bytes, frame, message).ok());
  return std::get<LinkUpdate>(message);
}

void expectSame(const LinkState& got, const LinkState& sent) {
  EXPECT_EQ(got.sequence, sent.sequence);
  EXPECT_EQ(got.time, sent.time);
  for (std::size_t i = 0; i < 6; ++i) EXPECT_NEAR(got.wave[i], sent.wave[i], 0.51 * kWaveQuantum);
  EXPECT_LE(got.energy, sent.energy + 1e-12);
  EXPECT_NEAR(got.energy, sent.energy, 1.01 * kEnergyQuantum);
  EXPECT_NEAR(got.fade, sent.fade, 1.0 / 255.0);
  EXPECT_EQ(got.on, sent.on);
  EXPECT_EQ(got.asks, sent.asks);
  EXPECT_EQ(got.regime, sent.regime);
  // Without a pose the last one is extrapolated, for a few packets at an acceleration of 0.2 m/s^2.
  EXPECT_LT(glm::length(got.worldFromDrawn.position - sent.worldFromDrawn.position), 2e-4);
  EXPECT_LT(glm::length(got.twist.linear - sent.twist.linear), 0.02);
}

TEST(LinkStream, IsWholeAfterTheWireHoweverLongItRuns) {
  LinkReceiver receiver;
  for (std::uint32_t i = 1; i < 60'000; ++i) {
    const LinkState sent = stateAt(i);
    const auto got = receiver.receive(onTheWire(sent), sent.time + 100 * kMillisecond);
    ASSERT_TRUE(got);
    if (i % 97 == 0 || i < 20) expectSame(*got, sent);
  }
}

TEST(LinkStream, LossDuplicatesAndReorderingChangeNoNumber) {
  std::mt19937 random(5);
  std::vector<std::pair<Micros, std::uint32_t>> arrivals;
  for (std::uint32_t i = 1; i < 20'000; ++i) {
    const bool outage = i % 5000 > 4500;  // 2 s
    if (i > 8 && (outage || random() % 10 < 3)) continue;
    for (int copies = random() % 10 == 0 ? 2 : 1; copies > 0; --copies)
      arrivals.emplace_back(stateAt(i).time + static_cast<Micros>(random() % 60'000), i);
  }
  std::sort(arrivals.begin(), arrivals.end());
  LinkReceiver receiver;
  int seen = 0;
  for (const auto& [now, sequence] : arrivals) {
    const LinkState sent = stateAt(sequence);
    const auto got = receiver.receive(onTheWire(sent), now);
    if (!got) continue;  // before the first pose
    ++seen;
    ASSERT_EQ(got->sequence, sent.sequence);
    ASSERT_EQ(got->time, sent.time);
    for (std::size_t i = 0; i < 6; ++i) ASSERT_NEAR(got->wave[i], sent.wave[i], 0.51 * kWaveQuantum);
    ASSERT_NEAR(got->energy, sent.energy, 1.01 * kEnergyQuantum);
  }
  EXPECT_GT(seen, 10'000);
}

TEST(LinkStream, ALargerEpochBeginsAnewAndAnEarlierOneIsDropped) {
  LinkReceiver receiver;
  for (std::uint32_t i = 1; i < 9000; ++i) receiver.receive(onTheWire(stateAt(i)), stateAt(i).time);
  LinkState begun = stateAt(1);
  begun.epoch = 8;
  begun.time += 100 * kSecond;
  const auto got = receiver.receive(onTheWire(begun), begun.time);
  ASSERT_TRUE(got);
  expectSame(*got, begun);
  EXPECT_FALSE(receiver.receive(onTheWire(stateAt(9000)), begun.time));
}

TEST(LinkStream, NoStateIsCompleteBeforeAPoseIsKnown) {
  LinkReceiver receiver;
  EXPECT_FALSE(receiver.receive(onTheWire(stateAt(24)), stateAt(24).time));
  EXPECT_TRUE(receiver.receive(onTheWire(stateAt(25)), stateAt(25).time));
  EXPECT_TRUE(receiver.receive(onTheWire(stateAt(26)), stateAt(26).time));
}

// A site that reconnects may send the time of its own clock before it knows the session's. Completed from its
// low bits, that time lies seconds ahead, and as the newest packet it would hide all later ones.
TEST(LinkStream, WhatLiesInTheFutureIsDropped) {
  LinkReceiver receiver;
  const Micros now = 9 * kSecond;
  LinkState first = stateAt(1);
  first.time = now;
  ASSERT_TRUE(receiver.receive(onTheWire(first), now));
  LinkState astray = stateAt(2);
  astray.time = 1000;
  EXPECT_FALSE(receiver.receive(onTheWire(astray), now));
  LinkState next = stateAt(3);
  next.time = now + 4000;
  const auto got = receiver.receive(onTheWire(next), now + 4000);
  ASSERT_TRUE(got);
  EXPECT_EQ(got->time, next.time);
}

/// 250 datagrams a second, sealed (32 bytes each), in one direction.
TEST(LinkStream, TakesLessThan24KilobytesASecond) {
  std::size_t bytes = 0;
  std::vector<std::byte> out;
  for (std::uint32_t i = 1; i <= 250; ++i) {
    encodeState(toWire(stateAt(1000 + i), 3, 5), WireFrame{}, out);
    bytes += out.size() + 32;
  }
  EXPECT_LT(bytes, 19'000u);
}

}  // namespace
}  // namespace tandem::sync
