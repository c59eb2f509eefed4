// The smaller pieces of a hand: its queue of commands and its guard against pauses of the loop.

#include <gtest/gtest.h>

#include "client/hand/command_queue.h"
#include "client/hand/stall_guard.h"

namespace tandem::client {
namespace {

using haptics::PartCommand;

TEST(CommandQueue, GivesATickWhatItTakesInOrder) {
  CommandQueue queue(10);
  EXPECT_TRUE(queue.empty());
  constexpr int kCount = haptics::kMaxPartCommands + 3;
  for (PartId part = 0; part < kCount; ++part) queue.push(PartCommand::Kind::own, part);
  const auto first = queue.nextBatch();
  ASSERT_EQ(first.size(), static_cast<std::size_t>(haptics::kMaxPartCommands));
  for (std::size_t i = 0; i < first.size(); ++i) EXPECT_EQ(first[i].part, i);
  EXPECT_FALSE(queue.empty());
  const auto second = queue.nextBatch();
  ASSERT_EQ(second.size(), 3u);
  EXPECT_EQ(second[0].part, haptics::kMaxPartCommands);
  EXPECT_TRUE(queue.empty());
  EXPECT_TRUE(queue.nextBatch().empty());
}

TEST(CommandQueue, HasRoomForTheCommandsOfAnEventUntilItIsNearlyFull) {
  CommandQueue queue(0);
  int pushed = 0;
  for (; queue.hasRoom(); ++pushed) queue.push(PartCommand::Kind::own, 0);
  for (int i = 0; i < haptics::kMaxPartCommands; ++i) queue.push(PartCommand::Kind::own, 0);
  EXPECT_DEATH(queue.push(PartCommand::Kind::own, 0), "");
  static_cast<void>(queue.nextBatch());
  EXPECT_FALSE(queue.hasRoom());
  static_cast<void>(queue.nextBatch());
  EXPECT_TRUE(queue.hasRoom());
}

haptics::DeviceSample good() {
  haptics::DeviceSample sample;
  sample.valid = true;
  return sample;
}

TEST(StallGuard, AfterAPauseOneTickHasNoReadingAndTheNextGraspsAnew) {
  StallGuard guard;
  sync::Micros now = 1000;
  EXPECT_FALSE(guard.noteTick(now));
  EXPECT_TRUE(guard.filter(good(), 0).sample.valid);
  now += StallGuard::kStall + 1;
  EXPECT_TRUE(guard.noteTick(now));
  for (std::size_t hand = 0; hand < haptics::kHands; ++hand) {
    EXPECT_FALSE(guard.filter(good(), hand).sample.valid);
    EXPECT_FALSE(guard.filter({}, hand).graspsAnew);
  }
  EXPECT_FALSE(guard.noteTick(now + 1000));
  haptics::DeviceSample none;
  none.valid = false;
  EXPECT_FALSE(guard.filter(none, 1).graspsAnew);  // it waits for a good reading
  EXPECT_TRUE(guard.filter(good(), 0).graspsAnew);
  EXPECT_TRUE(guard.filter(good(), 1).graspsAnew);
  EXPECT_FALSE(guard.filter(good(), 0).graspsAnew);
}

TEST(StallGuard, ReseatingHidesTheReadingsOfTheFirstHandOnly) {
  StallGuard guard;
  guard.noteTick(1000);
  guard.reseat();
  for (int i = 0; i < StallGuard::kReseatTicks; ++i) {
    EXPECT_FALSE(guard.filter(good(), 0).sample.valid);
    EXPECT_TRUE(guard.filter(good(), 1).sample.valid);
  }
  EXPECT_TRUE(guard.filter(good(), 0).sample.valid);
}

}  // namespace
}  // namespace tandem::client
