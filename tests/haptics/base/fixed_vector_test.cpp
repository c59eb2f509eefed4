#include "haptics/base/fixed_vector.h"

#include <gtest/gtest.h>

#include <memory>
#include <numeric>

#include "assets/base/assertion_scope.h"

namespace tandem::haptics {
namespace {

TEST(FixedVector, GrowsToItsCapacityAndKeepsItsOrder) {
  FixedVector<int, 3> list;
  EXPECT_TRUE(list.empty());
  EXPECT_EQ(list.capacity(), 3u);
  list.push_back(7);
  EXPECT_EQ(list.push_back(8), 8);
  EXPECT_FALSE(list.full());
  list.insert(list.begin() + 1, 9);
  EXPECT_TRUE(list.full());
  EXPECT_EQ(list.size(), 3u);
  EXPECT_EQ(list[0], 7);
  EXPECT_EQ(list[1], 9);
  EXPECT_EQ(list.back(), 8);
  EXPECT_EQ(std::accumulate(list.begin(), list.end(), 0), 24);
  list.pop_back();
  EXPECT_EQ(list.back(), 9);
  list.shrink(2);
  EXPECT_EQ(list.size(), 2u);
  list.erase(list.begin());
  EXPECT_EQ(list[0], 9);
  list.shrink(0);
  EXPECT_TRUE(list.empty());
  list.clear();
  EXPECT_TRUE(list.empty());
}

TEST(FixedVector, DestroysWhatLeaves) {
  const auto value = std::make_shared<int>(1);
  FixedVector<std::shared_ptr<int>, 4> list;
  list.push_back(value);
  list.push_back(value);
  EXPECT_EQ(value.use_count(), 3);
  list.pop_back();
  EXPECT_EQ(value.use_count(), 2);
  list.clear();
  EXPECT_EQ(value.use_count(), 1);
}

TEST(FixedVector, NeverReadsOrWritesBeyondItsElements) {
  FixedVector<int, 2> list;
  {
    const AssertionScope scope;
    EXPECT_THROW(list[0], FailedAssertion);
    EXPECT_THROW(list.back(), FailedAssertion);
    EXPECT_THROW(list.pop_back(), FailedAssertion);
    EXPECT_THROW(list.shrink(1), FailedAssertion);
    list.push_back(1);
    list.push_back(2);
    EXPECT_THROW(list.push_back(3), FailedAssertion);
    EXPECT_THROW(list.insert(list.begin(), 3), FailedAssertion);
    EXPECT_THROW(list[2], FailedAssertion);
  }
  EXPECT_EQ(list.size(), 2u);
  EXPECT_EQ(list[1], 2);
  EXPECT_DEATH(list[2], "broken invariant: i < elements_.size\\(\\)");
}

}  // namespace
}  // namespace tandem::haptics
