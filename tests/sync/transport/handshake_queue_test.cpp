#include "sync/transport/handshake_queue.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <random>

namespace tandem::sync {
namespace {

constexpr Network kHonest = 77;

/// A server's door on virtual time: it has room for so many and serves while it has nothing else to do.
struct Door {
  explicit Door(HandshakeRules rules = {}, std::size_t room = 4096) : queue(rules), places(room) {}

  VisitorId come(Network network, bool hello, std::optional<std::uint64_t> knock = {}) {
    if (queue.size() == places) queue.leave(queue.crowded());
    queue.enter(++last, network);
    if (hello) queue.ready(last, knock, now);
    return last;
  }
  /// Attackers come for a millisecond, then turns are given.
  void step(double perSecond, unsigned networks, bool hello, bool idle) {
    now += kMillisecond;
    for (due += perSecond / 1000.0; due >= 1.0; due -= 1.0) come(1000 + random() % networks, hello);
    while (const auto turn = queue.next(now, idle)) {
      servedAt[turn->visitor] = now;
      ++served[turn->network];
    }
  }
  HandshakeQueue queue;
  std::size_t places;
  std::mt19937 random{1};
  Micros now = 0;
  double due = 0.0;
  VisitorId last = 0;
  std::map<VisitorId, Micros> servedAt;
  std::map<Network, int> served;
};

/// Of ten honest peers without a knock, each from its own network, how many have their turns within three
/// seconds.
int honestServed(Door& door, unsigned networks, bool hello, bool idle) {
  std::map<VisitorId, Micros> came;
  for (int ms = 0; ms < 6000; ++ms) {
    if (ms >= 2000 && ms % 100 == 0 && came.size() < 10)
      came[door.come(kHonest + static_cast<Network>(ms), true)] = door.now;
    door.step(5000.0, networks, hello, idle);
  }
  int in = 0;
  for (const auto& [visitor, at] : came)
    in += door.servedAt.contains(visitor) && door.servedAt[visitor] - at <= 3 * kSecond ? 1 : 0;
  return in;
}

TEST(HandshakeQueue, AFreshNetworkHasItsTurnWhoeverFloods) {
  for (const unsigned networks : {1u, 30u, 1000u}) {
    for (const bool hello : {false, true}) {
      for (const bool idle : {false, true}) {
        Door door;
        EXPECT_EQ(honestServed(door, networks, hello, idle), 10) << networks << hello << idle;
      }
    }
  }
}

TEST(HandshakeQueue, WithoutTellingPeersApartItHasNone) {
  for (const unsigned networks : {1u, 1000u}) {
    HandshakeRules rules;
    rules.tellApart = false;
    Door door(rules, 32);
    EXPECT_LE(honestServed(door, networks, true, true), 3) << networks;
  }
}

TEST(HandshakeQueue, AKnockHasItsTurnAtOnceFromAnyNetworkUntilItsBudgetIsSpent) {
  Door door;
  for (int ms = 0; ms < 2000; ++ms) door.step(5000.0, 1, true, false);
  int soon = 0;
  for (int i = 0; i < 40; ++i) {
    const VisitorId visitor = door.come(1000, true, 5);
    for (int ms = 0; ms < 20; ++ms) door.step(5000.0, 1, true, false);
    soon += door.servedAt.contains(visitor) ? 1 : 0;
  }
  EXPECT_GE(soon, 8);
  EXPECT_LE(soon, 10);
}

TEST(HandshakeQueue, StrangersTakeNoMoreThanTheirRatesAndABusyServerGivesTheBaseRateOnly) {
  for (const bool idle : {false, true}) {
    Door door;
    for (int ms = 0; ms < 5000; ++ms) door.step(5000.0, 1000, true, idle);
    const double rate = static_cast<double>(door.servedAt.size()) / 5.0;
    EXPECT_LE(rate, idle ? 615.0 : 103.0);
    EXPECT_GE(rate, idle ? 550.0 : 95.0);
  }
}

TEST(HandshakeQueue, ANetworkBeyondItsBudgetGetsOnlyIdleTime) {
  Door door;
  for (int ms = 0; ms < 20000; ++ms) door.step(5000.0, 1, true, false);
  const int early = door.served[1000];
  EXPECT_LE(early, 500);  // 300 at once, and what fades
  for (int ms = 0; ms < 1000; ++ms) door.step(5000.0, 1, true, true);
  EXPECT_GE(door.served[1000] - early, 400);
}

TEST(HandshakeQueue, AFreshAddressWithManyGenuinePeersServesThemOneAfterAnotherUnderAFloodFromAThousand) {
  Door door;
  for (int ms = 0; ms < 5000; ++ms) door.step(5000.0, 1000, true, true);
  for (int i = 0; i < 100; ++i) {
    const VisitorId visitor = door.come(kHonest, true);
    for (int ms = 0; ms < 20; ++ms) door.step(5000.0, 1000, true, true);
    ASSERT_TRUE(door.servedAt.contains(visitor)) << i;
    door.queue.takeBack(kHonest, door.servedAt[visitor]);
  }
}

TEST(HandshakeQueue, NextAtIsWhenATurnCanBeGiven) {
  Door door;
  EXPECT_GT(door.queue.nextAt(0), kSecond * 1000);
  for (int i = 0; i < 500; ++i) door.come(5, true);
  int turns = 0;
  for (Micros at = 0; turns < 300; at = door.queue.nextAt(at)) {
    ASSERT_LT(at, 2 * kSecond);
    while (door.queue.next(at, true)) ++turns;
  }
}

TEST(Crowd, ItsFirstIsTheOldestOfTheLargestNetworkUnderEveryOrder) {
  for (unsigned seed = 0; seed < 50; ++seed) {
    std::mt19937 random(seed);
    const std::size_t handful = seed % 3 == 0 ? Crowd::kHandful : seed % 3;
    Crowd crowd(handful);
    std::map<VisitorId, Network> reference;
    VisitorId next = 1;
    for (int i = 0; i < 400; ++i) {
      if (random() % 3 != 0 || reference.empty()) {
        const Network network = random() % 5;
        reference[next] = network;
        crowd.add(next++, network);
      } else {
        const auto gone = std::next(reference.begin(), random() % reference.size());
        crowd.remove(gone->first);
        crowd.remove(gone->first);
        reference.erase(gone);
      }
      ASSERT_EQ(crowd.size(), reference.size());
      if (reference.empty()) continue;
      std::map<Network, std::size_t> sizes;
      for (const auto& [visitor, network] : reference) ++sizes[network];
      std::size_t most = 0;
      for (auto& [network, size] : sizes) most = std::max(most, size = std::max(size, handful));
      const auto first = std::find_if(reference.begin(), reference.end(),
                                      [&](const auto& entry) { return sizes[entry.second] == most; });
      ASSERT_EQ(crowd.first(), first->first);
    }
  }
}

TEST(RecentUse, CountsFadeAndKeepTheirOrder) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    std::mt19937 random(seed);
    RecentUse use(kSecond);
    std::map<std::uint64_t, std::vector<Micros>> uses;
    Micros now = 0;
    for (int i = 0; i < 500; ++i) {
      now += static_cast<Micros>(random() % 50000);
      const std::uint64_t key = random() % 4;
      uses[key].push_back(now);
      use.add(key, now);
    }
    const auto counted = [&](std::uint64_t key) {
      double sum = 0.0;
      for (const Micros at : uses[key]) sum += std::exp(-1e-6 * static_cast<double>(now - at));
      return sum;
    };
    for (std::uint64_t a = 0; a < 4; ++a) {
      EXPECT_NEAR(use.count(a, now), counted(a), 1e-6);
      for (std::uint64_t b = 0; b < 4; ++b) EXPECT_EQ(use.order(a) < use.order(b), counted(a) < counted(b));
    }
    EXPECT_EQ(use.count(99, now), 0.0);
  }
}

TEST(RecentUse, WhatIsTakenBackWasNeverUsed) {
  for (unsigned seed = 0; seed < 50; ++seed) {
    std::mt19937 random(seed);
    RecentUse use(kSecond), reference(kSecond);
    std::vector<Micros> extra;
    Micros now = 0;
    for (int i = 0; i < 40; ++i) {
      now += static_cast<Micros>(random() % 100000);
      use.add(7, now);
      if (random() % 2 == 0)
        reference.add(7, now);
      else
        extra.push_back(now);
    }
    std::shuffle(extra.begin(), extra.end(), random);
    for (const Micros at : extra) use.takeBack(7, at);
    EXPECT_NEAR(use.count(7, now), reference.count(7, now), 1e-6);
  }
  RecentUse use(kSecond);
  use.add(1, 5);
  use.takeBack(1, 5);
  use.takeBack(1, 5);
  EXPECT_EQ(use.order(1), RecentUse::kNone);
}

TEST(RecentUse, ForgetsWhoWasNotSeenForLongest) {
  RecentUse use(kSecond);
  for (std::uint64_t key = 0; key <= RecentUse::kMaxKeys; ++key) use.add(key, 0);
  EXPECT_EQ(use.order(0), RecentUse::kNone);
  EXPECT_GT(use.order(1), RecentUse::kNone);
}

}  // namespace
}  // namespace tandem::sync
