// Orders for links: they wait for their part, and one link has at most one.

#include "haptics/link/replica_links.h"

#include <gtest/gtest.h>

#include <vector>

namespace tandem::test {
namespace {

using haptics::LinkId;
using haptics::LinkTerms;
using haptics::ReplicaLinks;

LinkTerms terms(PartId part, SiteId peer, std::uint32_t epoch) {
  LinkTerms terms;
  terms.id = {part, peer};
  terms.epoch = epoch;
  return terms;
}

/// The epochs of the orders, in order; they stay.
std::vector<std::uint32_t> ordered(ReplicaLinks& links) {
  std::vector<std::uint32_t> epochs;
  links.beginOrders([&](const LinkTerms& order) {
    epochs.push_back(order.epoch);
    return false;
  });
  return epochs;
}

TEST(ReplicaLinks, AnOrderWaitsUntilItIsBegun) {
  ReplicaLinks links;
  links.order(terms(0, 2, 7));
  links.order(terms(1, 2, 8));
  links.beginOrders([](const LinkTerms& order) { return order.id.part == 1; });
  EXPECT_EQ(ordered(links), std::vector<std::uint32_t>{7});
  EXPECT_FALSE(links.any());
}

TEST(ReplicaLinks, ALaterOrderReplacesTheOneForTheSameLink) {
  ReplicaLinks links;
  links.order(terms(0, 2, 7));
  links.order(terms(0, 3, 8));
  links.order(terms(0, 2, 9));
  EXPECT_EQ(ordered(links), (std::vector<std::uint32_t>{8, 9}));
}

TEST(ReplicaLinks, AnOrderIsCancelledWithItsLinkOrItsPart) {
  ReplicaLinks links;
  for (const PartId part : {PartId{0}, PartId{1}})
    for (const SiteId peer : {SiteId{2}, SiteId{3}}) links.order(terms(part, peer, 10u * part + peer));
  links.end(LinkId{0, 2});
  EXPECT_EQ(ordered(links), (std::vector<std::uint32_t>{3, 12, 13}));
  links.cancelOrders(1);
  EXPECT_EQ(ordered(links), std::vector<std::uint32_t>{3});
}

TEST(ReplicaLinks, AnOrderWithoutRoomIsDropped) {
  ReplicaLinks links;
  for (int peer = 0; peer < ReplicaLinks::kMaxLinks + 1; ++peer)
    links.order(terms(0, static_cast<SiteId>(peer), static_cast<std::uint32_t>(peer)));
  EXPECT_EQ(ordered(links).size(), static_cast<std::size_t>(ReplicaLinks::kMaxLinks));
  EXPECT_EQ(ordered(links).back(), static_cast<std::uint32_t>(ReplicaLinks::kMaxLinks - 1));
}

TEST(ReplicaLinks, ALinkThatBeginsKeepsItsTermsAndIsReported) {
  ReplicaLinks links;
  haptics::RigidBody body;
  body.mass = 1.0;
  EXPECT_TRUE(links.begin(terms(0, 2, 7), body));
  EXPECT_TRUE(links.has(0));
  EXPECT_FALSE(links.has(1));
  EXPECT_EQ(links.report(0).count, 1);
  haptics::AddressedPacket packet{{0, 2}, {}};
  packet.packet.epoch = 6;
  EXPECT_FALSE(links.receive(packet));
  packet.packet.epoch = 7;
  EXPECT_TRUE(links.receive(packet));
  links.forget(0);
  EXPECT_FALSE(links.any());
}

}  // namespace
}  // namespace tandem::test
