// One encoding for many receivers: each decodes what was sent or nothing, whatever its network loses, and
// however it changes between shared and own encodings.

#include "sync/wire/shared_state_sender.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "sync/wire/state_receiver.h"
#include "sync/wire/state_sender.h"
#include "tests/sync/wire/random_messages.h"
#include "tests/sync/wire/sent_parts.h"

namespace tandem::sync {
namespace {

using testing::havePartsOf;
using testing::RandomMessages;
using Outcome = StateReceiver::Outcome;
const WireFrame kSharedFrame{{0.3, -1.0, 2.0}, 4.0};
constexpr Micros kSharedPeriod = 16 * kMillisecond;

/// A site whose parts wander, rest, and change their epoch.
class Origin {
 public:
  Origin(SiteId site, std::uint64_t seed, std::size_t parts) : random_(seed) {
    update_.site = site;
    for (std::size_t i = 0; i < parts; ++i) {
      update_.parts.emplace_back();
      update_.parts[i].part = static_cast<PartId>(site * 40u + i);
      update_.parts[i].worldFromPart = random_.pose(1.0);
    }
  }
  StateUpdate& next(Micros now) {
    update_.time = now;
    update_.newPresence = random_.chance(0.5);
    update_.presence.worldFromTool = random_.pose(1.0);
    if (random_.chance(0.05)) update_.presence.worldFromCamera = random_.pose(1.0);
    for (PartState& state : update_.parts) {
      ++state.sequence;
      if (random_.chance(0.003)) ++state.epoch;
      if (random_.chance(0.1)) state.twist = {};
      if (random_.chance(0.3)) state.twist = {random_.vector(0.3), random_.vector(1.0)};
      state.worldFromPart = integrate(state.worldFromPart, state.twist, toSeconds(kSharedPeriod));
    }
    return update_;
  }

 private:
  RandomMessages random_;
  StateUpdate update_;
};

bool isSharedAsSent(const StateUpdate& sent, const StateUpdate& got) {
  if (sent.time != got.time || sent.site != got.site) return false;
  if (got.newPresence && sent.presence.touched != got.presence.touched) return false;
  return havePartsOf(sent, got, kSharedFrame);
}

/// One receiver behind a network of its own.
struct Far {
  double loss = 0.0;
  Micros delay = 0;
  bool shares = true;  // false: its updates are encoded for it alone, for now
  SharedReceiver keys;
  StateSender own;
  StateReceiver receiver{kMaxSites};
  std::uint32_t sequence = 0;
  std::map<std::uint32_t, StateUpdate> sent;
  std::multimap<Micros, std::vector<std::byte>> there;
  std::multimap<Micros, StateAck> back;
  int arrived = 0, decoded = 0, wrong = 0;
  std::size_t bytes = 0;

  void take(std::span<const std::byte> message, RandomMessages& random, Micros now) {
    bytes += message.size();
    if (!random.chance(loss))
      there.emplace(now + delay + static_cast<Micros>(random.number(9000)),
                    std::vector<std::byte>(message.begin(), message.end()));
  }
  void listen(RandomMessages& random, Micros now) {
    StateMessage message;
    for (; !there.empty() && there.begin()->first <= now; there.erase(there.begin())) {
      ++arrived;
      if (receiver.decode(there.begin()->second, kSharedFrame, message) != Outcome::decoded) continue;
      ++decoded;
      const auto& got = std::get<StateUpdate>(message);
      wrong += isSharedAsSent(sent[got.sequence], got) ? 0 : 1;
    }
    if (const auto ack = receiver.drainAck(now))
      if (!random.chance(loss)) back.emplace(now + delay, *ack);
    for (; !back.empty() && back.begin()->first <= now; back.erase(back.begin())) {
      keys.acknowledged(back.begin()->second);
      own.acknowledged(back.begin()->second);
    }
  }
};

struct Crowd {
  RandomMessages random;
  std::vector<Origin> origins;
  std::vector<Far> receivers;
  SharedStateSender sender;
  Micros now = 0;
  std::uint64_t updates = 0;

  Crowd(std::uint64_t seed, std::size_t originCount, std::size_t receiverCount, double loss) : random(seed) {
    for (std::size_t i = 0; i < originCount; ++i)
      origins.emplace_back(static_cast<SiteId>(i + 1), seed * 100 + i, 1 + random.number(4));
    receivers.resize(receiverCount);
    for (Far& far : receivers) {
      far.loss = loss;
      far.delay = static_cast<Micros>(random.number(60'000));
    }
  }
  /// `turns`: how likely a receiver changes between shared and own encodings at an update.
  void run(int rounds, double turns) {
    std::vector<std::byte> bytes;
    for (int i = 0; i < rounds; ++i) {
      now += kSharedPeriod;
      for (Origin& origin : origins) {
        StateUpdate& update = origin.next(now);
        const bool toAll = random.chance(0.5);
        ++updates;
        sender.begin(update, kSharedFrame, toAll);
        for (Far& far : receivers) {
          if (!toAll && random.chance(0.5)) continue;
          if (random.chance(turns)) far.shares = !far.shares;
          StateUpdate& sent = far.sent[++far.sequence] = update;
          sent.sequence = far.sequence;
          if (far.shares) {
            far.take(sender.encodeFor(far.keys, far.sequence), random, now);
          } else {
            far.own.encode(sent, kSharedFrame, bytes);
            far.take(bytes, random, now);
          }
        }
      }
      for (Far& far : receivers) far.listen(random, now);
    }
  }
};

TEST(SharedState, EveryReceiverDecodesAllThatArrivesOnABadNetwork) {
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    Crowd crowd(seed, 3, 6, seed % 2 == 0 ? 0.0 : 0.25);
    crowd.run(400, 0.0);
    for (const Far& far : crowd.receivers) {
      EXPECT_EQ(far.wrong, 0) << seed;
      EXPECT_EQ(far.decoded, far.arrived) << "only acknowledged keys serve as baselines; seed " << seed;
      EXPECT_GT(far.arrived, 400) << seed;
    }
  }
}

TEST(SharedState, SharedAndOwnEncodingsTakeTurns) {
  for (std::uint64_t seed = 1; seed <= 8; ++seed)
    for (const double turns : {0.001, 0.02, 0.5}) {
      Crowd crowd(seed, 3, 4, 0.1);
      crowd.run(500, turns);
      for (const Far& far : crowd.receivers) {
        EXPECT_EQ(far.wrong, 0) << seed;
        EXPECT_EQ(far.decoded, far.arrived) << "seed " << seed << ", turns " << turns;
      }
    }
}

TEST(SharedState, AFewEncodingsServeHundredsOfReceivers) {
  Crowd crowd(5, 2, 300, 0.02);
  crowd.run(60, 0.0);
  const double each = static_cast<double>(crowd.sender.encodings()) / static_cast<double>(crowd.updates);
  EXPECT_LT(each, 7.0) << "encodings an update";
  std::size_t messages = 0;
  for (const Far& far : crowd.receivers) messages += far.sequence;
  EXPECT_GT(messages, 30 * crowd.sender.encodings());
}

TEST(SharedState, IsSmallOnceAcknowledged) {
  Crowd heard(1, 2, 4, 0.0), deaf(1, 2, 4, 1.0);  // where nothing arrives all is sent whole
  heard.run(300, 0.0);
  deaf.run(300, 0.0);
  EXPECT_LT(heard.receivers[0].bytes, deaf.receivers[0].bytes * 85 / 100);
}

TEST(SharedState, ALateReceiverGetsHandAndCameraWithItsFirstUpdate) {
  Crowd crowd(3, 1, 1, 0.0);
  crowd.run(100, 0.0);
  Far late;
  StateUpdate& update = crowd.origins[0].next(crowd.now + kSharedPeriod);
  update.newPresence = false;
  crowd.sender.begin(update, kSharedFrame, false);
  StateMessage message;
  ASSERT_EQ(late.receiver.decode(crowd.sender.encodeFor(late.keys, 1), kSharedFrame, message),
            Outcome::decoded);
  EXPECT_TRUE(std::get<StateUpdate>(message).presenceKnown);
}

TEST(SharedState, ASiteThatComesAfterAnotherLeftSharesNoBaselineWithIt) {
  Crowd crowd(4, 1, 3, 0.0);
  crowd.run(100, 0.0);
  crowd.sender.forget(1);
  crowd.origins.clear();
  crowd.origins.emplace_back(SiteId{77}, 9, 2);  // in the same slot
  crowd.run(100, 0.0);
  for (const Far& far : crowd.receivers) {
    EXPECT_EQ(far.wrong, 0);
    EXPECT_EQ(far.decoded, far.arrived);
  }
}

}  // namespace
}  // namespace tandem::sync
