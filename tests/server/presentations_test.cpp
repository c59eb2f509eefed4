// What sites show, through the server: who gets it, who may, and how much of it.

#include "server/presentations.h"

#include "tests/server/session_rig.h"

namespace tandem::server {
namespace {

struct PresentationsTest : testing::Test, SessionRig {
  static Presentation cut(double x, Shares shares = Shares::sections) {
    Presentation shown;
    shown.shares = shares;
    shown.sections = {{{x, 0.0, 0.0}, {1.0, 0.0, 0.0}}};
    return shown;
  }
  void settle() { run(150 * kMillisecond); }
  static SiteId siteOf(const FakeSite& site) { return site.last<Welcome>()->site; }
  /// What the site has been told last of what another one shares.
  static Presentation told(const FakeSite& to, const FakeSite& of) {
    for (auto at = to.received.rbegin(); at != to.received.rend(); ++at)
      if (const auto* shown = std::get_if<Presentation>(&*at); shown != nullptr && shown->site == siteOf(of))
        return *shown;
    return {};
  }
};

TEST_F(PresentationsTest, ReachTheOthersAndNewcomersWithTheTrueSite) {
  FakeSite& ada = join("ada");
  FakeSite& ben = join("ben", Role::observer);
  Presentation shown = cut(0.25, Shares::view);
  shown.site = 77;  // a lie
  shown.selected = shown.pointedAt = 1;
  shown.hidden = {4};
  ada.send(shown);
  settle();
  FakeSite& eve = join("eve");
  settle();
  for (const FakeSite* site : {&ben, &eve}) {
    const Presentation got = told(*site, ada);
    EXPECT_EQ(got.shares, Shares::view);
    ASSERT_EQ(got.sections.size(), 1u);
    EXPECT_EQ(got.sections[0].point.x, 0.25);
    EXPECT_EQ(got.selected, 1);
    EXPECT_EQ(got.pointedAt, 1);
    EXPECT_EQ(got.hidden, shown.hidden);
  }
  EXPECT_EQ(ada.count<Presentation>(), 0u) << "nobody hears of what they show themselves";
}

TEST_F(PresentationsTest, OfObserversAndOfUnknownPartsAreDroppedAndCounted) {
  FakeSite& watcher = join("watcher", Role::observer);
  FakeSite& ada = join("ada");
  watcher.send(cut(0.1));
  Presentation wrong = cut(0.1);
  wrong.selected = 3;  // there are three parts
  ada.send(wrong);
  wrong.selected = kNoPart;
  wrong.hidden = {1, 1};
  ada.send(wrong);
  for (const auto& [a, b] : {std::pair<PartId, PartId>{0, 3}, {1, 1}, {kNoPart, 0}}) {
    wrong = cut(0.1, Shares::view);
    wrong.inspection.a = a;
    wrong.inspection.b = b;
    ada.send(wrong);
  }
  wrong.inspection = {};
  wrong.inspection.marks = {{0, {}}, {kNoPart, {}}};
  ada.send(wrong);
  settle();
  EXPECT_EQ(session->counters().droppedPresentations, 7u);
  for (const FakeSite* site : {&watcher, &ada}) {
    EXPECT_EQ(site->count<Presentation>(), 0u);
    EXPECT_FALSE(site->closed);
  }
}

TEST_F(PresentationsTest, OneSiteSharesAtATimeAndWhoLostItSharesAgainOnlyAfterItHasStopped) {
  FakeSite& ada = join("ada");
  FakeSite& ben = join("ben");
  FakeSite& eve = join("eve");
  ada.send(cut(0.1));
  settle();
  ben.send(cut(0.2));
  settle();
  EXPECT_EQ(told(eve, ada).shares, Shares::nothing);
  EXPECT_EQ(told(eve, ben).shares, Shares::sections);
  EXPECT_EQ(told(ada, ada).site, siteOf(ada)) << "ada hears that its sharing has ended";
  EXPECT_EQ(told(ada, ada).shares, Shares::nothing);
  ada.send(cut(0.3));  // on its way before ada has heard
  settle();
  EXPECT_EQ(told(eve, ada).shares, Shares::nothing);
  EXPECT_TRUE(told(eve, ada).sections.empty());
  EXPECT_EQ(told(eve, ben).shares, Shares::sections);
  ada.send(Presentation{});
  ada.send(cut(0.4));
  settle();
  EXPECT_EQ(told(eve, ada).sections.at(0).point.x, 0.4);
  EXPECT_EQ(told(eve, ben).shares, Shares::nothing);
}

TEST_F(PresentationsTest, AParticipantDoesNotTakeOverFromAnInstructor) {
  FakeSite& ivan = join("ivan", Role::instructor);
  FakeSite& ben = join("ben");
  FakeSite& eve = join("eve");
  ivan.send(cut(0.1, Shares::view));
  settle();
  Presentation shown = cut(0.2, Shares::view);
  shown.pointedAt = 2;
  ben.send(shown);
  settle();
  EXPECT_EQ(told(ben, ben).site, siteOf(ben)) << "ben hears that";
  EXPECT_EQ(told(eve, ivan).shares, Shares::view);
  EXPECT_EQ(told(eve, ben).shares, Shares::nothing);
  EXPECT_EQ(told(eve, ben).pointedAt, 2) << "pointing is for everybody";
  ivan.send(Presentation{});
  ben.send(Presentation{});
  ben.send(shown);
  settle();
  EXPECT_EQ(told(eve, ben).shares, Shares::view);
  ivan.send(cut(0.1));
  settle();
  EXPECT_EQ(told(eve, ben).shares, Shares::nothing) << "an instructor takes over";
}

TEST_F(PresentationsTest, EndWithTheConnection) {
  FakeSite& ada = join("ada");
  FakeSite& ben = join("ben");
  ada.send(cut(0.1));
  settle();
  ada.transport->close(0);
  settle();
  EXPECT_EQ(told(ben, ada).shares, Shares::nothing);
  ben.send(cut(0.2));
  settle();
  FakeSite& eve = join("eve");
  settle();
  EXPECT_EQ(told(eve, ben).shares, Shares::sections);
}

TEST_F(PresentationsTest, OfAPeriodOnlyTheNewestIsSentAndWhatIsTooMuchIsDropped) {
  FakeSite& ada = join("ada");
  FakeSite& ben = join("ben");
  for (int i = 1; i <= 20; ++i) {
    ada.send(cut(0.01 * i));
    run(10 * kMillisecond);
  }
  settle();
  EXPECT_LE(ben.count<Presentation>(), 7u);
  EXPECT_EQ(told(ben, ada).sections.at(0).point.x, 0.01 * 20);
  EXPECT_EQ(session->counters().droppedPresentations, 0u);
  const std::size_t before = ben.count<Presentation>();
  for (int i = 1; i <= 100; ++i) ada.send(cut(0.001 * i));
  settle();
  EXPECT_GE(session->counters().droppedPresentations, 30u);
  EXPECT_LE(ben.count<Presentation>() - before, 4u);
  EXPECT_FALSE(ada.closed);
}

}  // namespace
}  // namespace tandem::server
