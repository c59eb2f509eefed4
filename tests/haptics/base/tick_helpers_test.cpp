#include "haptics/base/tick_helpers.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cfenv>
#include <chrono>
#include <thread>
#include <vector>

#include "assets/base/assert.h"

namespace tandem::test {
namespace {

using haptics::TickHelpers;

/// Whether a helper does one of many tasks within some seconds.
bool someHelp(TickHelpers& helpers) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  std::atomic<bool> helped{false};
  while (!helped && std::chrono::steady_clock::now() < end) {
    helpers.run(64, [&](int, int worker) {
      std::this_thread::sleep_for(std::chrono::microseconds(50));
      if (worker > 0) helped = true;
    });
  }
  return helped;
}

TEST(TickHelpers, DoEachTaskOnce) {
  for (int count = 0; count <= TickHelpers::kMost; ++count) {
    TickHelpers helpers(count);
    for (const int tasks : {0, 1, 3, 200}) {
      for (int round = 0; round < 300; ++round) {
        const TickHelpers::Awake awake(round % 3 == 0 ? nullptr : &helpers);
        std::vector<int> done(static_cast<std::size_t>(tasks), 0);
        std::atomic<bool> known{true};
        helpers.run(tasks, [&](int task, int worker) {
          ++done[static_cast<std::size_t>(task)];
          if (worker < 0 || worker > count) known = false;
        });
        ASSERT_TRUE(known);
        ASSERT_EQ(std::count(done.begin(), done.end(), 1), tasks);
      }
    }
  }
}

TEST(TickHelpers, HelpWhileTheyAreAwake) {
  TickHelpers helpers(2);
  const TickHelpers::Awake awake(&helpers);
  EXPECT_TRUE(someHelp(helpers));
}

TEST(TickHelpers, SleepOtherwise) {
  TickHelpers helpers(2);
  { const TickHelpers::Awake awake(&helpers); }
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  helpers.run(200, [](int, int worker) {
    std::this_thread::sleep_for(std::chrono::microseconds(50));
    EXPECT_EQ(worker, 0);
  });
}

TEST(TickHelpers, ThrowTheFailedAssertionOfATask) {
  TickHelpers helpers(1);
  const TickHelpers::Awake awake(&helpers);
  for (int round = 0; round < 100; ++round) {
    int line = 0;
    try {
      helpers.run(50, [](int task, int) { ASSERT(task != 31); });
    } catch (const FailedAssertion& failure) {
      line = failure.line;
    }
    EXPECT_GT(line, 0);
  }
  int done = 0;
  helpers.run(1, [&](int, int) { ++done; });
  EXPECT_EQ(done, 1);
}

TEST(TickHelpers, RoundAsTheThreadDoesThatShares) {
  TickHelpers helpers(1);
  const TickHelpers::Awake awake(&helpers);
  std::atomic<bool> same{true};
  const int before = std::fegetround();
  std::fesetround(FE_UPWARD);
  helpers.run(64, [&](int, int) {
    std::this_thread::sleep_for(std::chrono::microseconds(50));
    if (std::fegetround() != FE_UPWARD) same = false;
  });
  std::fesetround(before);
  EXPECT_TRUE(same);
}

}  // namespace
}  // namespace tandem::test
