#include "sync/replica/request_memory.h"

#include <gtest/gtest.h>

namespace tandem::sync {
namespace {

using Kind = RequestMemory::Kind;

TEST(RequestMemory, GivesTheAnswerToTheSameRequestOfTheSameSiteOnly) {
  RequestMemory memory;
  memory.remember(1, {Kind::reclaim, 7, 3, 2}, {Denial::stale, {3, 2, 5, {}}});
  const RequestMemory::Answer* answer = memory.find(1, {Kind::reclaim, 7, 3, 2});
  ASSERT_NE(answer, nullptr);
  EXPECT_EQ(answer->denial, Denial::stale);
  EXPECT_EQ(answer->record.epoch, 5u);
  EXPECT_EQ(memory.find(2, {Kind::reclaim, 7, 3, 2}), nullptr);
  EXPECT_EQ(memory.find(1, {Kind::release, 7, 3, 2}), nullptr);
  EXPECT_EQ(memory.find(1, {Kind::reclaim, 8, 3, 2}), nullptr);
  EXPECT_EQ(memory.find(1, {Kind::reclaim, 7, 4, 2}), nullptr);
  EXPECT_EQ(memory.find(1, {Kind::reclaim, 7, 3, 1}), nullptr);
}

TEST(RequestMemory, ForgetsTheOldestOfASiteFirstAndALeavingSiteWhole) {
  RequestMemory memory;
  memory.remember(2, {Kind::grab, 1, 0, 0}, {});
  for (RequestId request = 1; request <= RequestMemory::kPerSite + 1; ++request)
    memory.remember(1, {Kind::grab, request, 0, 0}, {});
  EXPECT_EQ(memory.find(1, {Kind::grab, 1, 0, 0}), nullptr);
  EXPECT_NE(memory.find(1, {Kind::grab, 2, 0, 0}), nullptr);
  EXPECT_NE(memory.find(2, {Kind::grab, 1, 0, 0}), nullptr);  // another site has room of its own
  memory.forget(1);
  EXPECT_EQ(memory.find(1, {Kind::grab, 2, 0, 0}), nullptr);
}

}  // namespace
}  // namespace tandem::sync
