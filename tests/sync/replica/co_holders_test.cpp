// The co-holders of a part, and which of them owns it after its owner.

#include <gtest/gtest.h>

#include "sync/replica/lease_rules.h"
#include "sync/replica/ownership_table.h"
#include "sync/replica/ownership_view.h"
#include "sync/wire/limits.h"
#include "sync/wire/ownership_messages.h"
#include "sync/wire/participant_messages.h"
#include "sync/wire/time.h"

namespace tandem::sync {
namespace {

constexpr SiteId kAnn = 1, kBen = 2, kCleo = 3;
constexpr Role kRole = Role::participant;

class CoHolders : public ::testing::Test {
 protected:
  LeaseRules rules;
  OwnershipTable table{{true, true, false}, std::vector<Pose>(3), rules};

  Epoch grab(SiteId site, Micros now = 0) {
    const auto decision = table.grab(site, kRole, {next++, 0}, now);
    EXPECT_EQ(decision.reply.denial, Denial::none);
    return decision.reply.part.epoch;
  }
  Denial engage(SiteId site, Micros now = 0, PartId part = 0) {
    return table.engage(site, kRole, {next++, part}, now).reply.denial;
  }
  void release(SiteId site, Epoch epoch) { EXPECT_TRUE(table.release(site, {next++, 0, epoch, {}}).changed); }

  RequestId next = 1;
};

TEST_F(CoHolders, IsForPartsThatSomebodyElseOwns) {
  EXPECT_EQ(engage(kBen), Denial::notOwned);
  grab(kAnn);
  EXPECT_EQ(engage(kAnn), Denial::notOwned);
  EXPECT_EQ(engage(kBen, 0, 2), Denial::notMovable);
  EXPECT_EQ(engage(kBen, 0, 9), Denial::unknownPart);
  EXPECT_EQ(table.engage(kBen, Role::observer, {1, 0}, 0).reply.denial, Denial::roleForbids);
  EXPECT_EQ(engage(kBen), Denial::none);
  EXPECT_EQ(table.coHolders(0).sites, std::vector<SiteId>{kBen});
}

TEST_F(CoHolders, TheirNumberIsLimitedAndWhoIsOneMayAskAgain) {
  grab(kAnn);
  for (SiteId i = 0; i < kMaxCoHolders; ++i) ASSERT_EQ(engage(static_cast<SiteId>(100 + i)), Denial::none);
  EXPECT_EQ(engage(kBen), Denial::crowded);
  EXPECT_EQ(engage(100), Denial::none);
  EXPECT_TRUE(table.disengage(100, {1, 0}).changed);
  EXPECT_EQ(engage(kBen), Denial::none);
  EXPECT_EQ(table.coHolders(0).sites.size(), kMaxCoHolders);
}

TEST_F(CoHolders, EachChangeOfTheListIsANewVersionPublishedOnce) {
  grab(kAnn);
  engage(kBen);
  const auto first = table.drainChangedCoHolders();
  ASSERT_EQ(first.size(), 1u);
  EXPECT_EQ(engage(kBen), Denial::none);  // a repeated request changes nothing
  EXPECT_TRUE(table.drainChangedCoHolders().empty());
  engage(kCleo);
  EXPECT_TRUE(table.disengage(kBen, {9, 0}).changed);
  EXPECT_FALSE(table.disengage(kBen, {9, 0}).changed);
  const auto second = table.drainChangedCoHolders();
  ASSERT_EQ(second.size(), 1u);
  EXPECT_GT(second[0].version, first[0].version);
  EXPECT_EQ(second[0].sites, std::vector<SiteId>{kCleo});
}

TEST_F(CoHolders, TheLongestCoHolderOwnsItNext) {
  const Epoch epoch = grab(kAnn);
  engage(kBen);
  engage(kCleo);
  release(kAnn, epoch);
  EXPECT_EQ(table.part(0).owner, kBen);
  EXPECT_EQ(table.part(0).epoch, epoch + 1);
  EXPECT_EQ(table.coHolders(0).sites, std::vector<SiteId>{kCleo});
  EXPECT_EQ(table.coHolders(0).epoch, epoch + 1);
  EXPECT_FALSE(table.accept(kAnn, {0, epoch, 5, {}, {}}));
  EXPECT_TRUE(table.accept(kBen, {0, epoch + 1, 1, {}, {}}));
}

TEST_F(CoHolders, ALeaseThatRunsOutPassesThePartOnToWhoIsStillThere) {
  const Epoch epoch = grab(kAnn);
  engage(kBen);
  engage(kCleo);
  const Micros later = rules.serverLease() - 1;
  table.renew(kCleo, later);
  const auto over = table.expire(later + 1);
  ASSERT_EQ(over.size(), 1u);
  EXPECT_EQ(over[0].owner, kCleo);
  EXPECT_EQ(over[0].epoch, epoch + 1);
  EXPECT_TRUE(table.coHolders(0).sites.empty()) << "the pings of Ben stopped";
}

TEST_F(CoHolders, AStrangerDoesNotGetThePartOfAnOwnerWhoIsGone) {
  const Epoch epoch = grab(kAnn);
  engage(kBen);
  const Micros later = rules.serverLease();
  table.renew(kBen, later);
  const auto decision = table.grab(kCleo, kRole, {next++, 0}, later);
  EXPECT_EQ(decision.reply.denial, Denial::ownedByOther);
  EXPECT_TRUE(decision.changed);
  EXPECT_EQ(decision.reply.part.owner, kBen);
  EXPECT_EQ(decision.reply.part.epoch, epoch + 1);
}

TEST_F(CoHolders, LeavingEndsIt) {
  grab(kAnn);
  engage(kBen);
  table.leave(kBen);
  EXPECT_TRUE(table.coHolders(0).sites.empty());
  engage(kCleo);
  EXPECT_EQ(table.leave(kAnn)[0].owner, kCleo);
}

TEST_F(CoHolders, ARevocationEndsAllOfIt) {
  const Epoch epoch = grab(kAnn);
  engage(kBen);
  const auto record = table.revoke(0);
  ASSERT_TRUE(record);
  EXPECT_EQ(record->owner, kNoSite);
  EXPECT_EQ(record->epoch, epoch + 1);
  EXPECT_TRUE(table.coHolders(0).sites.empty());
}

TEST_F(CoHolders, ASiteAppliesWhatIsNewer) {
  OwnershipView view(3, rules);
  view.setSelf(kBen);
  EXPECT_TRUE(view.apply(PartRecord{0, kAnn, 4, {}}));
  EXPECT_TRUE(view.apply(CoHolderRecord{0, 4, 2, {kBen, kCleo}}));
  EXPECT_FALSE(view.apply(CoHolderRecord{0, 4, 1, {}}));
  EXPECT_TRUE(view.isCoHolder(0));
  EXPECT_EQ(view.simulators(0), 3u);
  EXPECT_TRUE(view.apply(CoHolderRecord{0, 5, 1, {kCleo}}));
  EXPECT_FALSE(view.isCoHolder(0));
  EXPECT_FALSE(view.apply(CoHolderRecord{7, 5, 1, {}}));
  // A restarted server counts versions from the start.
  view.forgetCoHolders();
  EXPECT_TRUE(view.apply(CoHolderRecord{0, 4, 1, {kBen}}));
}

}  // namespace
}  // namespace tandem::sync
