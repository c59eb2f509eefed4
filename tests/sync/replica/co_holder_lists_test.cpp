#include "sync/replica/co_holder_lists.h"

#include <gtest/gtest.h>

namespace tandem::sync {
namespace {

TEST(CoHolderLists, TheLongestCoHolderIsFirstAndEveryChangeIsANewVersion) {
  CoHolderLists lists(2);
  EXPECT_TRUE(lists.add(1, 7, 0));
  EXPECT_TRUE(lists.add(1, 5, 0));
  EXPECT_FALSE(lists.add(1, 7, 0));
  EXPECT_EQ(lists.longest(1), 7);
  EXPECT_EQ(lists.record(1, 4), (CoHolderRecord{1, 4, 2, {7, 5}}));
  EXPECT_TRUE(lists.remove(1, 7));
  EXPECT_FALSE(lists.remove(1, 7));
  EXPECT_EQ(lists.longest(1), 5);
  EXPECT_EQ(lists.record(1, 4).version, 3u);
  EXPECT_FALSE(lists.contains(0, 5));
  EXPECT_FALSE(lists.longest(0).has_value());
}

TEST(CoHolderLists, ChangedPartsAreDrainedOnceInTheOrderOfTheirFirstChange) {
  CoHolderLists lists(3);
  lists.add(2, 1, 0);
  lists.add(0, 1, 0);
  lists.remove(2, 1);
  EXPECT_EQ(lists.drainChanged(), (std::vector<PartId>{2, 0}));
  EXPECT_TRUE(lists.drainChanged().empty());
}

TEST(CoHolderLists, ASiteWithoutPingsIsRemovedFromAllListsAndOneWithPingsStays) {
  CoHolderLists lists(2);
  lists.add(0, 1, 0);
  lists.add(1, 1, 0);
  lists.add(1, 2, 0);
  lists.renew(2, 50);
  lists.removeSilent(99, 100);
  EXPECT_TRUE(lists.contains(0, 1));
  lists.removeSilent(100, 100);
  EXPECT_FALSE(lists.contains(0, 1));
  EXPECT_EQ(lists.record(1, 0).sites, std::vector<SiteId>{2});
  EXPECT_EQ(lists.lastRenewed(2), 50);
}

}  // namespace
}  // namespace tandem::sync
