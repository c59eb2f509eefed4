// Sites say of each other that they do not believe their motion. The server tells everybody who says it of
// whom, and nothing else follows, however often it is said and by whom.

#include <algorithm>

#include "tests/server/session_rig.h"

namespace tandem::server {
namespace {

SiteId siteOf(const FakeSite& site) { return site.last<Welcome>()->site; }

std::vector<std::pair<SiteId, SiteId>> heardBy(const FakeSite& site, bool holds) {
  std::vector<std::pair<SiteId, SiteId>> heard;
  for (const ControlMessage& message : site.received)
    if (const auto* doubt = std::get_if<Doubt>(&message); doubt != nullptr && doubt->holds == holds)
      heard.emplace_back(doubt->site, doubt->about);
  return heard;
}

TEST(Doubts, AreToldToAllWithWhoSaysThemAndGoIntoAuditAndFigures) {
  SessionRig rig;
  FakeSite& ada = rig.join("Ada", Role::instructor);
  FakeSite& ben = rig.join("Ben");
  FakeSite& cid = rig.join("Cid");
  FakeSite& eve = rig.join("Eve", Role::observer);
  rig.session->drainAudit();
  ben.send(Doubt{siteOf(ada), siteOf(cid), true});  // the server knows better who says it
  rig.run(50 * kMillisecond);
  for (const FakeSite* site : {&ada, &ben, &cid, &eve})
    EXPECT_EQ(heardBy(*site, true), (std::vector{std::pair{siteOf(ben), siteOf(cid)}}));
  const std::vector<AuditEntry> audit = rig.session->drainAudit();
  ASSERT_EQ(audit.size(), 1u);
  EXPECT_EQ(audit[0].event, AuditEvent::doubted);
  EXPECT_EQ(audit[0].name, "Cid");
  EXPECT_NE(audit[0].detail.find("Ben"), std::string::npos);
  EXPECT_EQ(rig.session->counters().doubts, 1u);
  for (const ConnectedSite& site : rig.session->figures().sites)
    EXPECT_EQ(site.doubtedBy, site.site == siteOf(cid) ? 1u : 0u) << site.name;
  FakeSite& late = rig.join("Late");
  EXPECT_EQ(heardBy(late, true), (std::vector{std::pair{siteOf(ben), siteOf(cid)}}));
}

TEST(Doubts, EndWhenTheyAreNotSaidAgainAndWithEitherSite) {
  SessionRig rig;
  FakeSite& ada = rig.join("Ada");
  FakeSite& ben = rig.join("Ben");
  FakeSite& cid = rig.join("Cid");
  ada.send(Doubt{0, siteOf(ben), true});
  ben.send(Doubt{0, siteOf(cid), true});
  rig.run(40 * kSecond);
  ada.send(Doubt{0, siteOf(ben), true});
  rig.run(40 * kSecond);
  EXPECT_EQ(heardBy(cid, true).size(), 2u) << "what is said again is no news";
  EXPECT_EQ(heardBy(cid, false), (std::vector{std::pair{siteOf(ben), siteOf(cid)}}));
  ben.send(Goodbye{});
  rig.run(2 * kSecond);
  FakeSite& late = rig.join("Late");
  EXPECT_TRUE(heardBy(late, true).empty());
}

TEST(Doubts, OfObserversOfOneselfAndOfStrangersAreDropped) {
  SessionRig rig;
  FakeSite& ada = rig.join("Ada");
  FakeSite& eve = rig.join("Eve", Role::observer);
  eve.send(Doubt{0, siteOf(ada), true});
  ada.send(Doubt{0, siteOf(ada), true});
  ada.send(Doubt{0, 999, true});
  ada.send(Doubt{0, kNoSite, true});
  ada.send(Doubt{0, siteOf(eve), false});
  rig.run(50 * kMillisecond);
  EXPECT_EQ(ada.count<Doubt>() + eve.count<Doubt>(), 0u);
  EXPECT_EQ(rig.session->counters().droppedDoubts, 5u);
  EXPECT_FALSE(ada.closed);
}

TEST(Doubts, TakeNothingFromWhomTheyNameHoweverManySayThem) {
  SessionRig rig;
  FakeSite& ada = rig.join("Ada");
  const GrabReply held = rig.grab(ada, 0, 1);
  for (int i = 0; i < 5; ++i) {
    FakeSite& liar = rig.join("liar" + std::to_string(i), Role::instructor);
    liar.send(Doubt{0, siteOf(ada), true});
  }
  rig.run(3 * kSecond);
  EXPECT_EQ(rig.session->figures().sites[0].doubtedBy, 5u);
  EXPECT_EQ(rig.session->ownership().part(0).owner, siteOf(ada));
  EXPECT_EQ(rig.session->ownership().part(0).epoch, held.part.epoch);
  EXPECT_EQ(rig.grab(ada, 1, 2).denial, Denial::none);
}

TEST(Doubts, FloodCostsTheOthersFewMessages) {
  SessionRig rig;
  FakeSite& liar = rig.join("liar");
  FakeSite& ada = rig.join("Ada");
  std::vector<SiteId> others{siteOf(ada)};
  for (int i = 0; i < 20; ++i) others.push_back(siteOf(rig.join("site" + std::to_string(i))));
  rig.session->drainAudit();
  for (int second = 0; second < 20; ++second) {
    for (int i = 0; i < 100; ++i)
      liar.send(Doubt{0, others[static_cast<std::size_t>(second + i) % others.size()], true});
    rig.run(kSecond);
  }
  EXPECT_LE(ada.count<Doubt>(), 8u);
  EXPECT_GE(ada.count<Doubt>(), 1u);
  EXPECT_LE(rig.session->drainAudit().size(), 8u);
  EXPECT_GE(rig.session->counters().droppedDoubts, 1900u);
}

}  // namespace
}  // namespace tandem::server
