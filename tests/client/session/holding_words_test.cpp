#include "client/session/holding_words.h"

#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

namespace tandem::client {
namespace {

constexpr SiteId kAda = 1, kBen = 2, kCy = 3;
constexpr PartId kBlock = 0, kLid = 1, kPin = 2;

class HoldingWords : public testing::Test {
 protected:
  HoldingWords() {
    for (const char* name : {"block", "lid", "pin"}) scene_.parts.emplace_back().name = name;
    model_.scene = &scene_;
    model_.owner.assign(3, kNoSite);
    model_.coHolders.assign(3, {});
    for (const auto& [id, name] : {std::pair{kAda, "ada"}, std::pair{kBen, "ben"}, std::pair{kCy, "cy"}}) {
      SiteView site;
      site.info.site = id;
      site.info.name = name;
      site.info.connected = site.seen = true;
      model_.sites.push_back(site);
    }
    model_.sites[1].self = true;
  }

  void share(PartId part, SiteId owner, std::vector<SiteId> coHolders) {
    model_.owner[part] = owner;
    model_.coHolders[part] = std::move(coHolders);
  }
  std::string holding(SiteId site) const { return holdingInWords(model_, model_.sites[site - 1u]); }

  assets::Scene scene_;
  ViewModel model_;
};

TEST_F(HoldingWords, WhatNobodyHasHasNoWords) {
  EXPECT_EQ(holdersInWords(model_, kBlock), "");
  EXPECT_EQ(holdersInWords(model_, kNoPart), "");
  EXPECT_EQ(holding(kAda), "");
  EXPECT_EQ(sharingInWords(model_), "");
  EXPECT_EQ(partName(model_, kNoPart), "");
}

TEST_F(HoldingWords, AnOwnerAloneHoldsItsPart) {
  share(kBlock, kAda, {});
  EXPECT_EQ(holdersInWords(model_, kBlock), "ada");
  EXPECT_EQ(holding(kAda), "holds block");
  EXPECT_EQ(holding(kBen), "");
}

TEST_F(HoldingWords, AGuestHoldsThePartAsItsOwnerDoes) {
  share(kBlock, kAda, {kBen});
  EXPECT_EQ(holdersInWords(model_, kBlock), "ada with ben");
  EXPECT_EQ(holding(kAda), "holds block with ben");
  EXPECT_EQ(holding(kBen), "holds block with ada");
  EXPECT_EQ(holding(kCy), "");
}

TEST_F(HoldingWords, ThreePeopleAreAllNamed) {
  share(kBlock, kCy, {kAda, kBen});
  EXPECT_EQ(holdersInWords(model_, kBlock), "cy with ada and ben");
  EXPECT_EQ(holding(kCy), "holds block with ada and ben");
  EXPECT_EQ(holding(kAda), "holds block with cy and ben");
  EXPECT_EQ(holding(kBen), "holds block with cy and ada");
}

TEST_F(HoldingWords, SeveralPartsAreCountedAndTheSharedOnesNamed) {
  share(kLid, kAda, {});
  share(kPin, kAda, {});
  EXPECT_EQ(holding(kAda), "holds 2 parts");
  share(kBlock, kAda, {kBen});
  EXPECT_EQ(holding(kAda), "holds 3 parts, block with ben");
  share(kPin, kAda, {kBen, kCy});
  EXPECT_EQ(holding(kAda), "holds 3 parts, block with ben and pin with ben and cy");
  EXPECT_EQ(holding(kBen), "holds 2 parts, block with ada and pin with ada and cy");
  EXPECT_EQ(holding(kCy), "holds pin with ada and ben");
}

TEST_F(HoldingWords, AToolThatPushesAPartDoesNotHoldIt) {
  share(kBlock, kAda, {kCy});
  model_.sites[kCy - 1].presence.touched = kBlock;
  EXPECT_EQ(holding(kCy), "pushes block, which ada holds");
  share(kBlock, kAda, {kBen, kCy});
  EXPECT_EQ(holding(kCy), "pushes block, which ada and ben hold");
  model_.hand.held = kBlock;
  EXPECT_EQ(holding(kBen), "holds block with ada and cy");
}

TEST_F(HoldingWords, TheHandSaysWithWhomAndHowStiffly) {
  share(kBlock, kAda, {kBen});
  model_.hand.held = kBlock;
  model_.hand.links.count = model_.hand.links.live = 1;
  model_.hand.links.delay = 0.027;
  EXPECT_EQ(sharingInWords(model_), "with ada: coming up");
  model_.hand.links.fade = 1.0;
  EXPECT_EQ(sharingInWords(model_), "with ada: stiff (27 ms)");
  share(kBlock, kAda, {kBen, kCy});
  EXPECT_EQ(sharingInWords(model_), "with ada and cy: stiff (27 ms)");
}

TEST_F(HoldingWords, APartnerWhoLetsGoIsGoneFromTheWordsAtOnce) {
  share(kBlock, kBen, {kAda});
  model_.hand.held = kBlock;
  haptics::LinkReport& links = model_.hand.links;
  links.count = links.live = 1;
  links.fade = 1.0;
  EXPECT_EQ(sharingInWords(model_), "with ada: stiff (0 ms)");
  share(kBlock, kBen, {});
  links.live = 0;  // its force decays, and its packets come no more
  links.fade = 0.0;
  links.delay = 0.384;
  links.fresh = links.heard = false;
  links.regime = haptics::LinkRegime::apart;
  EXPECT_EQ(sharingInWords(model_), "");
  EXPECT_EQ(holding(kBen), "holds block");
  EXPECT_EQ(holding(kAda), "");
  EXPECT_EQ(holdersInWords(model_, kBlock), "ben");
}

TEST_F(HoldingWords, CoHoldersOfAPartWithoutAnOwnerAreOfThePast) {
  share(kBlock, kNoSite, {kBen});
  EXPECT_EQ(holdersInWords(model_, kBlock), "");
  EXPECT_EQ(holding(kBen), "");
}

TEST_F(HoldingWords, SitesThatTheSessionDoesNotKnowAreLeftOut) {
  share(kBlock, kAda, {77});
  EXPECT_EQ(holdersInWords(model_, kBlock), "ada");
  share(kBlock, 77, {kBen});
  EXPECT_EQ(holding(kBen), "holds block");
}

}  // namespace
}  // namespace tandem::client
