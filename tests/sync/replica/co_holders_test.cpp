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

constexpr SiteId kHolder = 1, kGuest = 2, kLatecomer = 3;
constexpr Role kParticipant = Role::participant;

class CoHolders : public ::testing::Test {
 protected:
  LeaseRules rules;
  OwnershipTable table{{true, true, false}, std::vector<Pose>(3), rules};

  Epoch grab(SiteId site, Micros now = 0) {
    const auto decision = table.grab(site, kParticipant, {next++, 0}, now);
    EXPECT_EQ(decision.reply.denial, Denial::none);
    return decision.reply.part.epoch;
  }
  Denial engage(SiteId site, Micros now = 0, PartId part = 0) {
    return table.engage(site, kParticipant, {next++, part}, now).reply.denial;
  }
  void release(SiteId site, Epoch epoch) { EXPECT_TRUE(table.release(site, {next++, 0, epoch, {}}).changed); }

  RequestId next = 1;
};

TEST_F(CoHolders, IsForPartsThatSomebodyElseOwns) {
  EXPECT_EQ(engage(kGuest), Denial::notOwned);
  grab(kHolder);
  EXPECT_EQ(engage(kHolder), Denial::notOwned);
  EXPECT_EQ(engage(kGuest, 0, 2), Denial::notMovable);
  EXPECT_EQ(engage(kGuest, 0, 9), Denial::unknownPart);
  EXPECT_EQ(table.engage(kGuest, Role::observer, {1, 0}, 0).reply.denial, Denial::roleForbids);
  EXPECT_EQ(engage(kGuest), Denial::none);
  EXPECT_EQ(table.coHolders(0).sites, std::vector<SiteId>{kGuest});
}

TEST_F(CoHolders, TheirNumberIsLimitedAndWhoIsOneMayAskAgain) {
  grab(kHolder);
  for (SiteId i = 0; i < kMaxCoHolders; ++i) ASSERT_EQ(engage(static_cast<SiteId>(100 + i)), Denial::none);
  EXPECT_EQ(engage(kGuest), Denial::crowded);
  EXPECT_EQ(engage(100), Denial::none);
  EXPECT_TRUE(table.disengage(100, {1, 0}).changed);
  EXPECT_EQ(engage(kGuest), Denial::none);
  EXPECT_EQ(table.coHolders(0).sites.size(), kMaxCoHolders);
}

TEST_F(CoHolders, EachChangeOfTheListIsANewVersionPublishedOnce) {
  grab(kHolder);
  engage(kGuest);
  const auto first = table.drainChangedCoHolders();
  ASSERT_EQ(first.size(), 1u);
  EXPECT_EQ(engage(kGuest), Denial::none);  // a repeated request changes nothing
  EXPECT_TRUE(table.drainChangedCoHolders().empty());
  engage(kLatecomer);
  EXPECT_TRUE(table.disengage(kGuest, {9, 0}).changed);
  EXPECT_FALSE(table.disengage(kGuest, {9, 0}).changed);
  const auto second = table.drainChangedCoHolders();
  ASSERT_EQ(second.size(), 1u);
  EXPECT_GT(second[0].version, first[0].version);
  EXPECT_EQ(second[0].sites, std::vector<SiteId>{kLatecomer});
}

TEST_F(CoHolders, TheLongestCoHolderOwnsItNext) {
  const Epoch epoch = grab(kHolder);
  engage(kGuest);
  engage(kLatecomer);
  release(kHolder, epoch);
  EXPECT_EQ(table.part(0).owner, kGuest);
  EXPECT_EQ(table.part(0).epoch, epoch + 1);
  EXPECT_EQ(table.coHolders(0).sites, std::vector<SiteId>{kLatecomer});
  EXPECT_EQ(table.coHolders(0).epoch, epoch + 1);
  EXPECT_FALSE(table.accept(kHolder, {0, epoch, 5, {}, {}}));
  EXPECT_TRUE(table.accept(kGuest, {0, epoch + 1, 1, {}, {}}));
}

TEST_F(CoHolders, ALeaseThatRunsOutPassesThePartOnToWhoIsStillThere) {
  const Epoch epoch = grab(kHolder);
  engage(kGuest);
  engage(kLatecomer);
  const Micros later = rules.serverLease() - 1;
  table.renew(kLatecomer, later);
  const auto over = table.expire(later + 1);
  ASSERT_EQ(over.size(), 1u);
  EXPECT_EQ(over[0].owner, kLatecomer);
  EXPECT_EQ(over[0].epoch, epoch + 1);
  EXPECT_TRUE(table.coHolders(0).sites.empty()) << "the pings of Ben stopped";
}

TEST_F(CoHolders, AStrangerDoesNotGetThePartOfAnOwnerWhoIsGone) {
  const Epoch epoch = grab(kHolder);
  engage(kGuest);
  const Micros later = rules.serverLease();
  table.renew(kGuest, later);
  const auto decision = table.grab(kLatecomer, kParticipant, {next++, 0}, later);
  EXPECT_EQ(decision.reply.denial, Denial::ownedByOther);
  EXPECT_TRUE(decision.changed);
  EXPECT_EQ(decision.reply.part.owner, kGuest);
  EXPECT_EQ(decision.reply.part.epoch, epoch + 1);
}

TEST_F(CoHolders, LeavingEndsIt) {
  grab(kHolder);
  engage(kGuest);
  table.leave(kGuest);
  EXPECT_TRUE(table.coHolders(0).sites.empty());
  engage(kLatecomer);
  EXPECT_EQ(table.leave(kHolder)[0].owner, kLatecomer);
}

TEST_F(CoHolders, ARevocationEndsAllOfIt) {
  const Epoch epoch = grab(kHolder);
  engage(kGuest);
  const auto record = table.revoke(0);
  ASSERT_TRUE(record);
  EXPECT_EQ(record->owner, kNoSite);
  EXPECT_EQ(record->epoch, epoch + 1);
  EXPECT_TRUE(table.coHolders(0).sites.empty());
}

TEST_F(CoHolders, ASiteAppliesWhatIsNewer) {
  OwnershipView view(3, rules);
  view.setSelf(kGuest);
  EXPECT_TRUE(view.apply(PartRecord{0, kHolder, 4, {}}));
  EXPECT_TRUE(view.apply(CoHolderRecord{0, 4, 2, {kGuest, kLatecomer}}));
  EXPECT_FALSE(view.apply(CoHolderRecord{0, 4, 1, {}}));
  EXPECT_TRUE(view.isCoHolder(0));
  EXPECT_EQ(view.simulators(0), 3u);
  EXPECT_TRUE(view.apply(CoHolderRecord{0, 5, 1, {kLatecomer}}));
  EXPECT_FALSE(view.isCoHolder(0));
  EXPECT_FALSE(view.apply(CoHolderRecord{7, 5, 1, {}}));
  // A restarted server counts versions from the start.
  view.forgetCoHolders();
  EXPECT_TRUE(view.apply(CoHolderRecord{0, 4, 1, {kGuest}}));
}

}  // namespace
}  // namespace tandem::sync
