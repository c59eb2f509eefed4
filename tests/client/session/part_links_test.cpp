// The network side of coordination links: which links ownership asks for, by which terms and in which epochs.

#include "client/session/part_links.h"

#include <gtest/gtest.h>

#include <vector>

#include "tests/client/hand/box_row.h"

namespace tandem::client {
namespace {

using Heard = NetworkEvent::Kind;
using sync::Micros;

constexpr SiteId kSelf = 1, kOneSite = 2, kOtherSite = 3;
constexpr PartId kBox = 0;

class PartLinksTest : public testing::Test {
 protected:
  PartLinksTest() { view_.setSelf(kSelf); }

  void own(SiteId owner) { view_.apply(sync::PartRecord{kBox, owner, ++epoch_, {}}); }
  void coHold(std::vector<SiteId> sites) {
    view_.apply(sync::CoHolderRecord{kBox, epoch_, ++version_, std::move(sites)});
  }
  /// The events of this kind that following ownership causes now.
  std::vector<NetworkEvent> follow(Heard kind) {
    links_.follow(view_, kBox, now_);
    return eventsOf(kind);
  }
  std::vector<NetworkEvent> eventsOf(Heard kind) {
    std::vector<NetworkEvent> events = links_.drainEvents();
    std::erase_if(events, [&](const NetworkEvent& event) { return event.kind != kind; });
    return events;
  }

  /// The first packet of the first site for its link of the box, which is on.
  sync::LinkUpdate firstUpdate(Epoch epoch, SiteId from = kOneSite) const {
    sync::LinkState state;
    state.epoch = epoch;
    state.sequence = 1;
    state.time = now_;
    state.on = true;
    return sync::toWire(state, from, kBox);
  }

  assets::Scene scene_ = test::rowOfBoxes();
  sync::OwnershipView view_{3, {}};
  PartLinks links_{scene_, 4e-3};
  Micros now_ = 100 * sync::kSecond;
  Epoch epoch_ = 0;
  std::uint32_t version_ = 0;
};

TEST_F(PartLinksTest, AnOwnerLinksEachCoHolderOnce) {
  own(kSelf);
  EXPECT_TRUE(follow(Heard::link).empty());
  coHold({kOneSite});
  const auto begun = follow(Heard::link);
  ASSERT_EQ(begun.size(), 1u);
  EXPECT_EQ(begun[0].link.id, (haptics::LinkId{kBox, kOneSite}));
  EXPECT_FALSE(begun[0].ownedByPeer);
  EXPECT_EQ(begun[0].link.parameters.packetPeriod, 4e-3);
  EXPECT_EQ(begun[0].link.parameters.longestDelay, haptics::longestDelay(false));
  EXPECT_TRUE(follow(Heard::link).empty());
  coHold({});
  const auto ended = follow(Heard::unlink);
  ASSERT_EQ(ended.size(), 1u);
  EXPECT_EQ(ended[0].link.id, (haptics::LinkId{kBox, kOneSite}));
}

TEST_F(PartLinksTest, LinksThatGetLighterBeginAnewInALaterEpoch) {
  own(kSelf);
  coHold({kOneSite});
  const auto alone = follow(Heard::link);
  std::vector<SiteId> many{kOneSite};
  for (SiteId site = kOtherSite; site < kOtherSite + 6; ++site) many.push_back(site);
  coHold(many);
  const auto all = follow(Heard::link);
  ASSERT_EQ(all.size(), many.size());
  EXPECT_EQ(all[0].link.id.peer, kOneSite);
  EXPECT_GT(all[0].link.epoch, alone[0].link.epoch);
  EXPECT_LT(all[0].link.parameters.impedance, alone[0].link.parameters.impedance);
}

TEST_F(PartLinksTest, ASilentLinkBeginsAnewByTheSameTerms) {
  own(kSelf);
  coHold({kOneSite});
  const auto begun = follow(Heard::link);
  links_.beginSilentAnew(view_, now_ + PartLinks::kSilence - 1);
  EXPECT_TRUE(eventsOf(Heard::link).empty());
  links_.beginSilentAnew(view_, now_ + PartLinks::kSilence);
  const auto again = eventsOf(Heard::link);
  ASSERT_EQ(again.size(), 1u);
  EXPECT_GT(again[0].link.epoch, begun[0].link.epoch);
  EXPECT_EQ(again[0].link.parameters.impedance, begun[0].link.parameters.impedance);
}

TEST_F(PartLinksTest, ACoHolderTakesEpochAndTermsFromTheOwnersPacket) {
  own(kOneSite);
  coHold({kSelf});
  EXPECT_TRUE(follow(Heard::link).empty());
  EXPECT_FALSE(links_.felt(kBox, kOneSite));
  sync::LinkUpdate update = firstUpdate(6000);
  update.posed = true;
  update.terms = {20.0, 10.0, 2e-3};
  const auto packet = links_.receive(update, view_, now_);
  const auto begun = eventsOf(Heard::link);
  ASSERT_EQ(begun.size(), 1u);
  EXPECT_TRUE(begun[0].ownedByPeer);
  EXPECT_EQ(begun[0].link.epoch, 6000u);
  EXPECT_EQ(begun[0].link.parameters.impedance, 20.0);
  EXPECT_EQ(begun[0].link.parameters.softImpedance, 10.0);
  EXPECT_EQ(begun[0].link.parameters.packetPeriod, 2e-3);
  ASSERT_TRUE(packet.has_value());
  EXPECT_EQ(packet->link, begun[0].link.id);
  EXPECT_TRUE(links_.felt(kBox, kOneSite));
  // The answer goes out by the same terms, and only in the epoch of the link.
  haptics::AddressedPacket answer{packet->link, {}};
  answer.packet.epoch = 6000;
  const auto out = links_.toWire(answer);
  ASSERT_TRUE(out.has_value());
  EXPECT_EQ(out->terms, update.terms);
  answer.packet.epoch = 5999;
  EXPECT_FALSE(links_.toWire(answer).has_value());
}

TEST_F(PartLinksTest, TheNextOwnersLinkBeginsThoughItsClockIsBehindTheLastOwners) {
  own(kOneSite);
  coHold({kSelf});
  sync::LinkUpdate update = firstUpdate(6000);
  update.posed = true;
  EXPECT_TRUE(links_.receive(update, view_, now_).has_value());
  own(kOtherSite);
  coHold({kSelf});
  EXPECT_EQ(follow(Heard::unlink).size(), 1u);
  static_cast<void>(links_.drainEvents());
  sync::LinkUpdate next = firstUpdate(5990, kOtherSite);
  next.posed = true;
  EXPECT_TRUE(links_.receive(next, view_, now_).has_value());
  EXPECT_EQ(eventsOf(Heard::link).size(), 1u);
  // What is late of a link that this peer began before stays without effect.
  own(kOneSite);
  coHold({kSelf});
  EXPECT_EQ(follow(Heard::unlink).size(), 1u);
  EXPECT_FALSE(links_.receive(update, view_, now_).has_value());
}

TEST_F(PartLinksTest, APacketOfNobodysLinkIsDropped) {
  own(kOneSite);
  sync::LinkUpdate update = firstUpdate(6000);
  EXPECT_FALSE(links_.receive(update, view_, now_).has_value());  // this site is no co-holder
  update.part = 99;
  EXPECT_FALSE(links_.receive(update, view_, now_).has_value());
  EXPECT_TRUE(links_.drainEvents().empty());
}

}  // namespace
}  // namespace tandem::client
