#include "sync/transport/virtual_network.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <vector>

namespace tandem::sync {
namespace {

using Kind = TransportEvent::Kind;

std::vector<std::byte> number(std::uint32_t n) {
  return {std::byte(n & 255), std::byte(n >> 8 & 255), std::byte(n >> 16 & 255)};
}
std::uint32_t number(std::span<const std::byte> bytes) {
  return std::to_integer<std::uint32_t>(bytes[0]) | std::to_integer<std::uint32_t>(bytes[1]) << 8 |
         std::to_integer<std::uint32_t>(bytes[2]) << 16;
}
struct Seen {
  Kind kind;
  ConnectionId connection;
  std::uint32_t number;
  std::string reason;
};
std::vector<Seen> drain(Transport& transport) {
  std::vector<Seen> seen;
  TransportEvent event;
  while (transport.poll(event)) {
    seen.push_back(
        {event.kind, event.connection, event.bytes.empty() ? 0 : number(event.bytes), event.reason});
  }
  return seen;
}

TEST(VirtualNetwork, EachLegTakesHalfOfTheDelay) {
  VirtualNetwork network(1, {.oneWay = 50 * kMillisecond});
  auto server = network.listen();
  auto site = network.connect("a");
  network.advanceTo(25 * kMillisecond - 1);
  EXPECT_TRUE(drain(*server).empty());
  network.advanceTo(25 * kMillisecond);
  ASSERT_EQ(drain(*server).size(), 1u);
  ASSERT_EQ(drain(*site).size(), 1u);
  site->sendState(0, number(7));
  network.advanceTo(50 * kMillisecond - 1);
  EXPECT_TRUE(drain(*server).empty());
  network.advanceTo(50 * kMillisecond);
  const auto seen = drain(*server);
  ASSERT_EQ(seen.size(), 1u);
  EXPECT_EQ(seen[0].number, 7u);
}

/// Everything that a lossy run delivers, as one list.
std::vector<std::uint32_t> lossyRun(std::uint64_t seed, std::map<std::uint32_t, int>* states = nullptr) {
  const NetworkConditions bad{
      .oneWay = 50 * kMillisecond, .jitter = 0.5, .loss = 0.2, .duplicate = 0.1, .reorder = 0.1};
  VirtualNetwork network(seed, bad);
  auto server = network.listen();
  auto site = network.connect("a");
  std::vector<std::uint32_t> log;
  std::uint32_t expected = 0;
  network.advanceTo(100 * kMillisecond);
  drain(*server);
  for (std::uint32_t i = 0; i < 20000; ++i) {
    network.advanceTo(100 * kMillisecond + i * kMillisecond);
    if (i < 19000) {
      site->sendState(0, number(i));
      if (i % 10 == 0) site->sendControl(0, number(i));
    }
    for (const Seen& seen : drain(*server)) {
      log.push_back(seen.number * 2 + (seen.kind == Kind::control ? 1 : 0));
      if (seen.kind == Kind::control) {
        EXPECT_EQ(seen.number, expected) << "control is in order and whole";
        expected += 10;
      } else if (states != nullptr) {
        ++(*states)[seen.number];
      }
    }
  }
  EXPECT_EQ(expected, 19000u);
  return log;
}

TEST(VirtualNetwork, TheSameSeedGivesTheSameDeliveries) {
  EXPECT_EQ(lossyRun(5), lossyRun(5));
  EXPECT_NE(lossyRun(5), lossyRun(6));
}

TEST(VirtualNetwork, LosesAndDoublesAsOftenAsAsked) {
  std::map<std::uint32_t, int> states;
  lossyRun(7, &states);
  int twice = 0;
  for (const auto& [n, count] : states) twice += count > 1 ? 1 : 0;
  // One leg of two: 1 - sqrt(1 - p) each.
  EXPECT_NEAR(1.0 - static_cast<double>(states.size()) / 19000.0, 1.0 - std::sqrt(0.8), 0.01);
  EXPECT_NEAR(twice / static_cast<double>(states.size()), 1.0 - std::sqrt(0.9), 0.01);
}

TEST(VirtualNetwork, ABlackoutLosesStateAndHoldsControlBack) {
  VirtualNetwork network(1, {.oneWay = 20 * kMillisecond});
  auto server = network.listen();
  auto a = network.connect("a");
  auto b = network.connect("b");
  network.advanceTo(20 * kMillisecond);
  drain(*server);
  a->sendControl(0, number(1));  // under way when the blackout begins
  a->sendState(0, number(2));
  network.blackout("a", kSecond);
  a->sendControl(0, number(3));
  a->sendState(0, number(4));
  b->sendState(0, number(5));
  network.advanceTo(kSecond - 1);
  auto seen = drain(*server);
  ASSERT_EQ(seen.size(), 1u);
  EXPECT_EQ(seen[0].number, 5u);
  network.advanceTo(kSecond);
  seen = drain(*server);
  ASSERT_EQ(seen.size(), 2u);
  EXPECT_EQ(seen[0].number, 1u);
  EXPECT_EQ(seen[1].number, 3u);
}

TEST(VirtualNetwork, ACrashedServerIsNoticedAndAnotherCanListen) {
  VirtualNetwork network(1, {.oneWay = 20 * kMillisecond});
  auto server = network.listen();
  auto site = network.connect("a");
  network.advanceTo(20 * kMillisecond);
  drain(*site);
  server->sendControl(1, number(9));
  server.reset();
  site->sendControl(0, number(1));
  network.advanceTo(40 * kMillisecond);
  auto seen = drain(*site);
  ASSERT_EQ(seen.size(), 2u) << "what was sent before the crash arrives";
  EXPECT_EQ(seen[0].number, 9u);
  EXPECT_EQ(seen[1].kind, Kind::closed);
  EXPECT_FALSE(seen[1].reason.empty());

  auto early = network.connect("a");
  network.advanceTo(60 * kMillisecond);
  seen = drain(*early);
  ASSERT_EQ(seen.size(), 1u);
  EXPECT_EQ(seen[0].kind, Kind::closed);
  auto next = network.listen();
  auto again = network.connect("a");
  network.advanceTo(80 * kMillisecond);
  ASSERT_EQ(drain(*again).at(0).kind, Kind::connected);
  ASSERT_EQ(drain(*next).size(), 1u) << "nothing of the old connection";
}

TEST(VirtualNetwork, ACrashedSiteIsNoticedLate) {
  VirtualNetwork network(1, {.oneWay = 20 * kMillisecond});
  auto server = network.listen();
  auto site = network.connect("a", 500 * kMillisecond);
  network.advanceTo(20 * kMillisecond);
  drain(*server);
  site.reset();
  network.advanceTo(529 * kMillisecond);
  EXPECT_TRUE(drain(*server).empty());
  network.advanceTo(530 * kMillisecond);
  EXPECT_EQ(drain(*server).at(0).kind, Kind::closed);
}

TEST(VirtualNetwork, TellsWhenTheServerLastReceivedSomethingOfADeadSite) {
  VirtualNetwork network(1, {.oneWay = 20 * kMillisecond});
  auto server = network.listen();
  auto site = network.connect("a");
  network.advanceTo(20 * kMillisecond);
  site->sendState(0, number(1));
  network.advanceTo(25 * kMillisecond);
  site->sendState(0, number(2));
  network.advanceTo(31 * kMillisecond);
  EXPECT_EQ(network.lastFromTheDead("a"), 0) << "it lives";
  site.reset();
  network.advanceTo(2 * kSecond);
  EXPECT_EQ(network.lastFromTheDead("a"), 35 * kMillisecond);
}

TEST(VirtualNetwork, TellsWhenTheServerLastReceivedSomethingOfASiteThatClosed) {
  VirtualNetwork network(1, {.oneWay = 20 * kMillisecond});
  auto server = network.listen();
  auto site = network.connect("a");
  network.advanceTo(20 * kMillisecond);
  site->sendState(0, number(1));
  site->close(0);
  network.advanceTo(2 * kSecond);
  EXPECT_EQ(network.lastFromTheDead("a"), 30 * kMillisecond);
}

TEST(VirtualNetwork, WhatLossesHaveHeldBackArrivesInOrderOnceTheWayIsGoodAgain) {
  VirtualNetwork network(1, {.oneWay = 20 * kMillisecond});
  auto server = network.listen();
  auto site = network.connect("a");
  network.advanceTo(20 * kMillisecond);
  drain(*server);
  network.setPath("a", {.delay = kSecond, .loss = 1.0});
  for (std::uint32_t n = 0; n < 20; ++n) site->sendControl(0, number(n));
  network.advanceTo(kSecond);
  ASSERT_TRUE(drain(*server).empty());
  network.healAll();
  site->sendControl(0, number(20));
  network.advanceTo(kSecond + 60 * kMillisecond);
  const auto seen = drain(*server);
  ASSERT_EQ(seen.size(), 21u);
  for (std::uint32_t n = 0; n < 21; ++n) EXPECT_EQ(seen[n].number, n);
}

TEST(VirtualNetwork, CloseSendsWhatIsQueuedAndClosesBothEnds) {
  VirtualNetwork network(1, {});
  auto server = network.listen();
  auto site = network.connect("a");
  network.advanceTo(0);
  drain(*site);
  const ConnectionId id = drain(*server).at(0).connection;
  server->sendControl(id, number(3));
  EXPECT_EQ(server->controlBacklog(id), 3u);
  server->close(id);
  server->sendControl(id, number(4));
  network.advanceTo(1);
  const auto seen = drain(*site);
  ASSERT_EQ(seen.size(), 2u);
  EXPECT_EQ(seen[0].number, 3u);
  EXPECT_EQ(seen[1].kind, Kind::closed);
  const auto own = drain(*server);
  ASSERT_EQ(own.size(), 1u);
  EXPECT_TRUE(own[0].reason.empty());
}

}  // namespace
}  // namespace tandem::sync
