// Updates from end to end with losses, duplicates and reordering: each is decoded as it was sent, or not at
// all.

#include "sync/wire/state_receiver.h"
#include "sync/wire/state_sender.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "tests/sync/wire/random_messages.h"
#include "tests/sync/wire/sent_parts.h"

namespace tandem::sync {
namespace {

using testing::havePartsOf;
using testing::RandomMessages;
using Outcome = StateReceiver::Outcome;
const WireFrame kStreamFrame{{0.3, -1.0, 2.0}, 4.0};
constexpr Micros kPeriod = 4 * kMillisecond;

/// Parts of one site that move, come to rest, change epoch, come and go.
class Parts {
 public:
  explicit Parts(std::uint64_t seed) : random_(seed) {}
  StateUpdate next() {
    time_ += kPeriod;
    StateUpdate update;
    update.site = 3;
    update.sequence = ++sequence_;
    update.time = time_;
    update.newPresence = random_.chance(0.2);
    update.presence.touched = static_cast<PartId>(sequence_ % 1000);
    for (Part& part : parts_) {
      step(part);
      if (part.here) update.parts.push_back(part.state);
    }
    return update;
  }

 private:
  struct Part {
    PartState state;
    bool here = false, moves = false;
  };
  void step(Part& part) {
    PartState& state = part.state;
    if (random_.chance(0.002)) part.here = !part.here;
    if (random_.chance(0.01)) part.moves = !part.moves;
    if (random_.chance(0.002)) {
      ++state.epoch;
      state.worldFromPart = random_.pose(1.0);
    }
    if (part.moves) {
      state.twist.linear += random_.vector(0.01);
      state.twist.angular += random_.vector(0.05);
      state.worldFromPart = integrate(state.worldFromPart, state.twist, toSeconds(kPeriod));
    } else {
      state.twist = {};
    }
    state.part = static_cast<PartId>(10 + (&part - parts_.data()));
    state.sequence = sequence_;
  }
  RandomMessages random_;
  std::array<Part, 6> parts_{};
  std::uint32_t sequence_ = 0;
  Micros time_ = 0;
};

/// Whether a decoded update is the sent one, as quantised by the wire.
bool isThatSent(const StateUpdate& sent, const StateUpdate& got) {
  return sent.sequence == got.sequence && sent.time == got.time && sent.site == got.site &&
         havePartsOf(sent, got, kStreamFrame);
}

struct Lossy {
  double loss = 0.0, duplicate = 0.0, reorder = 0.0;
  Micros delay = 12 * kMillisecond;
};
struct Tally {
  int arrived = 0, decoded = 0, noBaseline = 0, wrong = 0;
  std::size_t bytes = 0;
};

/// One stream over a bad network, acknowledgements included; the receiver forgets all at `forgetsAt`.
Tally run(std::uint64_t seed, const Lossy& network, int rounds, int forgetsAt = -1) {
  RandomMessages random(seed);
  Parts parts(seed + 1000);
  StateSender sender;
  StateReceiver receiver;
  std::map<std::uint32_t, StateUpdate> sent;
  std::multimap<Micros, std::vector<std::byte>> there;
  std::multimap<Micros, StateAck> back;
  Tally tally;
  StateMessage message;
  Micros now = 0;
  const auto delay = [&] {
    return network.delay + static_cast<Micros>(random.real(-0.2, 0.2) * static_cast<double>(network.delay)) +
           (random.chance(network.reorder) ? network.delay : 0);
  };
  for (int i = 0; i < rounds; ++i) {
    now += kPeriod;
    if (i == forgetsAt) receiver.reset();
    const StateUpdate update = parts.next();
    sent[update.sequence] = update;
    std::vector<std::byte> bytes;
    EncodeLosses losses;
    sender.encode(update, kStreamFrame, bytes, &losses);
    EXPECT_EQ(losses.leftOut, 0);
    tally.bytes += bytes.size();
    for (int copy = 0; copy < (random.chance(network.duplicate) ? 2 : 1); ++copy)
      if (!random.chance(network.loss)) there.emplace(now + delay(), bytes);
    for (; !there.empty() && there.begin()->first <= now; there.erase(there.begin())) {
      ++tally.arrived;
      const Outcome outcome = receiver.decode(there.begin()->second, kStreamFrame, message);
      tally.noBaseline += outcome == Outcome::noBaseline ? 1 : 0;
      if (outcome != Outcome::decoded) continue;
      ++tally.decoded;
      const auto& got = std::get<StateUpdate>(message);
      tally.wrong += isThatSent(sent[got.sequence], got) ? 0 : 1;
    }
    if (const auto ack = receiver.drainAck(now))
      if (!random.chance(network.loss)) back.emplace(now + delay(), *ack);
    for (; !back.empty() && back.begin()->first <= now; back.erase(back.begin()))
      sender.acknowledged(back.begin()->second);
  }
  return tally;
}

TEST(StateStream, DecodesWhatWasSentOrNothingOnABadNetwork) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const Tally bad = run(seed, {0.3, 0.1, 0.2, 60 * kMillisecond}, 2000);
    EXPECT_EQ(bad.wrong, 0);
    EXPECT_EQ(bad.decoded, bad.arrived) << "an update against an acknowledged state can be decoded";
    EXPECT_GT(bad.arrived, 1300);
  }
}

TEST(StateStream, IsSmallOnceAcknowledged) {
  const Tally near = run(1, {}, 2000);
  // 125 ms a leg: the baselines are a quarter of a second old.
  const Tally far = run(1, {0.0, 0.0, 0.0, 125 * kMillisecond}, 2000);
  const Tally never = run(1, {1.0, 0.0, 0.0, 0}, 2000);  // nothing arrives: all is sent whole
  EXPECT_LT(near.bytes, never.bytes * 7 / 10);
  EXPECT_LT(far.bytes, never.bytes * 9 / 10);
}

TEST(StateStream, AReceiverThatHasForgottenDropsAndCountsAndIsWellWithinASecond) {
  const int before = 500, rounds = 1000;
  const Tally tally = run(5, {}, rounds, before);
  EXPECT_EQ(tally.wrong, 0);
  EXPECT_GT(tally.noBaseline, 0);
  EXPECT_LE(tally.noBaseline, static_cast<int>(kKept * kKeepInterval / kPeriod) + 10);
  EXPECT_EQ(tally.decoded + tally.noBaseline, tally.arrived);
}

/// A sender and a receiver without a network, after a few acknowledged rounds.
struct Pair {
  StateSender sender;
  StateReceiver receiver;
  StateUpdate update;
  std::vector<std::byte> bytes;
  StateMessage message;

  void advance() {
    ++update.sequence;
    update.time += kPeriod;
    for (PartState& state : update.parts) {
      state.sequence = update.sequence;
      state.worldFromPart = integrate(state.worldFromPart, state.twist, toSeconds(kPeriod));
    }
    sender.encode(update, kStreamFrame, bytes);
  }
  Outcome deliver() {
    const Outcome outcome = receiver.decode(bytes, kStreamFrame, message);
    if (const auto ack = receiver.drainAck(update.time)) sender.acknowledged(*ack);
    return outcome;
  }
  void rounds(int count) {
    for (int i = 0; i < count; ++i) {
      advance();
      ASSERT_EQ(deliver(), Outcome::decoded);
    }
  }
};

std::vector<PartState> partsAt(std::size_t count, const Twist& twist) {
  std::vector<PartState> parts(count);
  for (std::size_t i = 0; i < count; ++i) {
    parts[i].part = static_cast<PartId>(i);
    parts[i].epoch = 4;
    parts[i].worldFromPart.position =
        kStreamFrame.centre + glm::dvec3(0.001 * static_cast<double>(i), 0.0, 0.0);
    parts[i].twist = twist;
  }
  return parts;
}

TEST(StateStream, APartAtRestTakesOneBit) {
  std::size_t sizes[2] = {};
  for (int i = 0; i < 2; ++i) {
    Pair pair;
    pair.update.parts = partsAt(i == 0 ? 8 : 32, {});
    pair.rounds(40);
    pair.update.newPresence = false;
    pair.advance();
    sizes[i] = pair.bytes.size();
  }
  EXPECT_EQ(sizes[1] - sizes[0], 3u) << "24 parts more";
  EXPECT_LE(sizes[0], 20u);
}

TEST(StateStream, NeverLongerThanADatagramAndTheFirstPartsComeFirst) {
  Pair pair;
  pair.update.parts = partsAt(200, {{0.1, 0.2, 0.3}, {1.0, 2.0, 3.0}});
  std::vector<bool> seen(200);
  std::size_t most = 0;
  for (int round = 0; round < 200; ++round) {
    pair.advance();
    ASSERT_LE(pair.bytes.size(), kMaxStateBytes);
    ASSERT_EQ(pair.deliver(), Outcome::decoded);
    const auto& parts = std::get<StateUpdate>(pair.message).parts;
    most = std::max(most, parts.size());
    for (const PartState& state : parts) seen[state.part] = true;
    ASSERT_TRUE(std::any_of(parts.begin(), parts.end(), [](const PartState& s) { return s.part == 0; }));
  }
  EXPECT_GT(most, 60u) << "whole, only 33 fit";
}

TEST(StateStream, AnUpdateAgainstOtherStatesIsNotDecoded) {
  // Two histories with the same sequences and times, and different poses.
  Pair here, other;
  here.update.parts = partsAt(1, {{0.1, 0.0, 0.0}, {}});
  other.update.parts = partsAt(1, {{0.1, 0.0, 0.0}, {}});
  other.update.parts[0].worldFromPart.position.y += 0.01;
  here.rounds(30);
  other.rounds(30);
  here.advance();
  other.advance();
  EXPECT_EQ(here.receiver.decode(other.bytes, kStreamFrame, here.message), Outcome::checksumMismatch);
  EXPECT_EQ(here.deliver(), Outcome::decoded);
}

TEST(StateStream, AStateOfAnotherEpochIsSentWhole) {
  Pair pair;
  pair.update.parts = partsAt(1, {});
  pair.rounds(30);
  pair.update.newPresence = false;
  pair.advance();
  const std::size_t small = pair.bytes.size();
  ASSERT_EQ(pair.deliver(), Outcome::decoded);
  ++pair.update.parts[0].epoch;
  pair.advance();
  EXPECT_GT(pair.bytes.size(), small + 15);
  ASSERT_EQ(pair.deliver(), Outcome::decoded);
  EXPECT_EQ(std::get<StateUpdate>(pair.message).parts[0].epoch, 5u);
}

TEST(StateStream, PresenceComesWhereItIsNewAndIsRememberedOtherwise) {
  Pair pair;
  pair.update.site = 9;
  pair.update.newPresence = false;
  pair.update.presence.touched = 7;
  pair.advance();
  ASSERT_EQ(pair.deliver(), Outcome::decoded);
  const auto& got = std::get<StateUpdate>(pair.message);
  EXPECT_TRUE(got.newPresence) << "the receiver had none";
  pair.update.presence.touched = 8;
  pair.advance();
  const std::size_t without = pair.bytes.size();
  ASSERT_EQ(pair.deliver(), Outcome::decoded);
  EXPECT_FALSE(got.newPresence);
  EXPECT_EQ(got.presence.touched, 7);
  EXPECT_EQ(got.presence.site, 9);
  pair.update.newPresence = true;
  pair.advance();
  EXPECT_EQ(pair.bytes.size(), without + 40);
  ASSERT_EQ(pair.deliver(), Outcome::decoded);
  EXPECT_EQ(got.presence.touched, 8);
}

TEST(StateStream, TheCameraIsSentWhereItMovesAndAtIntervals) {
  Pair pair;
  pair.update.newPresence = true;
  std::vector<std::size_t> sizes;
  const auto advance = [&](double x, bool arrives) {
    pair.update.presence.worldFromCamera.position.x = x;
    pair.advance();
    sizes.push_back(pair.bytes.size());
    if (arrives) {
      ASSERT_EQ(pair.deliver(), Outcome::decoded);
    }
  };
  const auto shown = [&] { return std::get<StateUpdate>(pair.message).presence.worldFromCamera.position.x; };
  for (int i = 0; i < 9; ++i) advance(0.5, true);
  const std::size_t with = sizes[0];
  for (std::size_t i = 0; i < 9; ++i) EXPECT_EQ(sizes[i], with - (i < 4 || i == 8 ? 0 : 16)) << i;
  EXPECT_NEAR(shown(), 0.5, 1e-5);
  for (int i = 0; i < 3; ++i) advance(0.25, false);
  advance(0.25, true);
  EXPECT_NEAR(shown(), 0.25, 1e-5) << "three lost in a row are made up for";
}

TEST(StateStream, ACameraThatWasOvertakenCounts) {
  Pair pair;
  pair.update.newPresence = true;
  for (int i = 0; i < 4; ++i) {
    pair.advance();
    ASSERT_EQ(pair.deliver(), Outcome::decoded);
  }
  pair.update.presence.worldFromCamera.position.x = 0.5;
  pair.advance();
  const auto late = pair.bytes;
  for (int i = 0; i < 3; ++i) pair.advance();
  pair.advance();  // without the camera
  ASSERT_EQ(pair.deliver(), Outcome::decoded);
  const auto& got = std::get<StateUpdate>(pair.message);
  EXPECT_NEAR(got.presence.worldFromCamera.position.x, 0.0, 1e-5);
  pair.bytes = late;
  ASSERT_EQ(pair.deliver(), Outcome::decoded);
  pair.advance();
  ASSERT_EQ(pair.deliver(), Outcome::decoded);
  EXPECT_NEAR(got.presence.worldFromCamera.position.x, 0.5, 1e-5);
}

TEST(StateStream, AHandWithoutEyesIsNotShown) {
  Pair pair;
  pair.update.newPresence = true;
  for (int i = 0; i < 4; ++i) pair.advance();  // updates with the camera, which are lost
  pair.advance();
  ASSERT_EQ(pair.deliver(), Outcome::decoded);
  auto& got = std::get<StateUpdate>(pair.message);
  EXPECT_FALSE(got.newPresence);
  EXPECT_FALSE(got.presenceKnown);
  StateSender onward;
  StateReceiver other;
  StateMessage message;
  onward.encode(got, kStreamFrame, pair.bytes);
  ASSERT_EQ(other.decode(pair.bytes, kStreamFrame, message), Outcome::decoded);
  EXPECT_FALSE(std::get<StateUpdate>(message).presenceKnown) << "nor by who passes it on";
  for (int i = 0; i < 4; ++i) pair.advance();
  ASSERT_EQ(pair.deliver(), Outcome::decoded);
  EXPECT_TRUE(got.newPresence);
  EXPECT_TRUE(got.presenceKnown);
}

TEST(StateStream, HostileBytesGiveValidStatesOrNone) {
  RandomMessages random(31);
  Pair pair;
  pair.update.parts = partsAt(5, {{0.1, 0.0, 0.2}, {1.0, 0.0, 0.0}});
  pair.rounds(60);
  std::map<Outcome, int> outcomes;
  for (int round = 0; round < 30000; ++round) {
    pair.advance();
    auto bytes = pair.bytes;
    for (std::uint32_t flips = 1 + random.number(4); flips > 0; --flips)
      bytes[2 + random.number(static_cast<std::uint32_t>(bytes.size()) - 2)] ^=
          static_cast<std::byte>(1u << random.number(8));
    if (random.chance(0.1)) bytes.resize(random.number(static_cast<std::uint32_t>(bytes.size())));
    StateReceiver receiver = pair.receiver;
    const Outcome outcome = receiver.decode(bytes, kStreamFrame, pair.message);
    ++outcomes[outcome];
    if (outcome == Outcome::decoded)
      if (const auto* got = std::get_if<StateUpdate>(&pair.message))
        for (const PartState& state : got->parts) {
          ASSERT_TRUE(isValid(state.worldFromPart));
          ASSERT_LT(state.part, kMaxParts);
        }
    if (round % 10 == 0) {
      ASSERT_EQ(pair.deliver(), Outcome::decoded);
    }
  }
  EXPECT_GT(outcomes[Outcome::malformed], 1000);
  EXPECT_GT(outcomes[Outcome::checksumMismatch], 1000);
  EXPECT_GT(outcomes[Outcome::noBaseline], 100);
}

TEST(StateStream, EveryTruncationIsRefused) {
  Pair pair;
  pair.update.parts = partsAt(3, {{0.1, 0.0, 0.2}, {1.0, 0.0, 0.0}});
  pair.rounds(30);
  pair.advance();
  for (std::size_t length = 0; length < pair.bytes.size(); ++length) {
    StateReceiver receiver = pair.receiver;
    EXPECT_NE(receiver.decode(std::span(pair.bytes).first(length), kStreamFrame, pair.message),
              Outcome::decoded);
  }
  pair.bytes.push_back(std::byte{0});
  EXPECT_EQ(pair.deliver(), Outcome::malformed);
}

TEST(StateStream, AcknowledgementsComeBack) {
  StateAck ack;
  ack.count = 2;
  ack.sequences = {7, 0xfffffff0u};
  std::vector<std::byte> bytes;
  encodeState(ack, kStreamFrame, bytes);
  StateMessage message;
  ASSERT_TRUE(decodeState(bytes, kStreamFrame, message).ok());
  EXPECT_EQ(std::get<StateAck>(message).count, 2);
  EXPECT_EQ(std::get<StateAck>(message).sequences[1], 0xfffffff0u);
  bytes[2] = std::byte{0};
  EXPECT_FALSE(decodeState(bytes, kStreamFrame, message).ok());
  bytes[2] = std::byte{3};
  EXPECT_FALSE(decodeState(bytes, kStreamFrame, message).ok());
}

}  // namespace
}  // namespace tandem::sync
