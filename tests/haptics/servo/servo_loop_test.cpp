#include "haptics/servo/servo_loop.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <glm/geometric.hpp>
#include <limits>
#include <stdexcept>
#include <thread>

#include "assets/base/assert.h"
#include "haptics/servo/servo_schedule.h"

namespace tandem::haptics {
namespace {

/// Notes what it is told; its limits are those of a small device.
class RecordingDevice : public Device {
 public:
  std::string name() const override { return "recording"; }
  DeviceLimits limits() const override {
    DeviceLimits limits;
    limits.maxForce = 3.0;
    limits.maxTorque = 0.1;
    return limits;
  }
  Status open() override { return {}; }
  void close() override {}
  DeviceSample poll(double now) override {
    polls.fetch_add(1);
    DeviceSample sample;
    sample.time = now;
    sample.valid = true;
    return sample;
  }
  void apply(const Wrench& toHand) override {
    last = toHand;
    if (glm::length(toHand.force) > largest) largest = glm::length(toHand.force);
    if (glm::length(toHand.torque) > glm::length(largestTorque)) largestTorque = toHand.torque;
    applied.fetch_add(1);
  }

  std::atomic<int> polls{0}, applied{0};
  std::atomic<double> largest{0.0};  // N
  Wrench last;                       // read after stop()
  glm::dvec3 largestTorque{0.0, 0.0, 0.0};
};

void waitForTicks(const ServoLoop& loop, std::uint64_t ticks) {
  while (loop.statistics().ticks < ticks) std::this_thread::sleep_for(std::chrono::milliseconds(1));
}

TEST(ServoSchedule, KeepsToTheGridWhenOnTime) {
  ServoSchedule schedule(1000, 100);
  for (int i = 1; i <= 10; ++i) {
    EXPECT_EQ(schedule.deadline_ns(), 1000 + 100 * i);
    EXPECT_FALSE(schedule.woke(schedule.deadline_ns() + 50));
    EXPECT_EQ(schedule.advance(schedule.deadline_ns() + 60), 0);
  }
}

TEST(ServoSchedule, CallsAWakeUpLateBeyondHalfAPeriod) {
  ServoSchedule schedule(0, 100);
  EXPECT_FALSE(schedule.woke(150));
  EXPECT_TRUE(schedule.woke(151));
}

TEST(ServoSchedule, SkipsPeriodsThatHavePassedInsteadOfCatchingUp) {
  ServoSchedule schedule(0, 100);
  EXPECT_EQ(schedule.advance(1234), 11) << "deadlines 200..1200";
  EXPECT_EQ(schedule.deadline_ns(), 1300);
  EXPECT_EQ(schedule.advance(1300), 0);
  EXPECT_EQ(schedule.deadline_ns(), 1400);
}

TEST(EffortGuard, TakesEffortBackInItsOrderAndGivesItBackOnceTicksAreShort) {
  EffortGuard guard;
  const ContactEffort set;
  const auto ticks = [&](int count, double share) {
    for (int i = 0; i < count; ++i) guard.note(share);
  };
  ticks(EffortGuard::kLimit - 1, 0.9);
  EXPECT_EQ(guard.stage(), 0) << "a few long ticks are forgiven";
  EXPECT_EQ(guard.limited(set).sampleQueries, set.sampleQueries);
  EXPECT_TRUE(guard.limited(set).descend);
  ticks(1, 0.9);
  EXPECT_EQ(guard.limited(set).sampleQueries, set.sampleQueries / 2);
  EXPECT_EQ(guard.limited(set).steps, set.steps);
  EXPECT_FALSE(guard.limited(set).descend);
  ticks(EffortGuard::kLimit, 0.9);
  EXPECT_EQ(guard.limited(set).sampleQueries, set.sampleQueries / 4);
  EXPECT_EQ(guard.limited(set).steps, 2);
  ticks(10 * EffortGuard::kLimit, 0.9);
  EXPECT_EQ(guard.limited(set).sampleQueries, set.sampleQueries / 8);
  EXPECT_EQ(guard.limited(set).steps, 1);
  EXPECT_TRUE(guard.limited(set).exact) << "what is touched stays exact";
  ticks(EffortGuard::kCalm - 1, 0.1);
  EXPECT_EQ(guard.stage(), EffortGuard::kMaxStages);
  ticks(1, 0.1);
  EXPECT_EQ(guard.stage(), EffortGuard::kMaxStages - 1) << "a stage at a time";
  ticks(4 * EffortGuard::kCalm, 0.5);
  EXPECT_EQ(guard.stage(), EffortGuard::kMaxStages - 1) << "between both bounds nothing changes";
  ticks(2 * EffortGuard::kCalm, 0.1);
  EXPECT_EQ(guard.stage(), 0);
}

TEST(EffortGuard, GivesNoMoreThanIsSet) {
  EffortGuard guard;
  EXPECT_EQ(guard.limited({1, 10, false}).sampleQueries, 10);
  EXPECT_EQ(guard.limited({1, 10, false}).steps, 1);
  EXPECT_FALSE(guard.limited({1, 10, false}).exact);
}

TEST(OverrunGuard, ForgivesAFewOverrunsAndHoldsZeroAfterMany) {
  OverrunGuard guard;
  for (int i = 0; i < 1000; ++i) EXPECT_FALSE(guard.note(i % 8 == 0)) << i;  // 8 of 64
  bool tripped = false;
  for (int i = 0; i < OverrunGuard::kLimit; ++i) tripped = guard.note(true);
  EXPECT_TRUE(tripped);
  for (int i = 0; i < OverrunGuard::kWindow - 1; ++i) EXPECT_TRUE(guard.note(false)) << i;
  EXPECT_FALSE(guard.note(false));
}

TEST(ServoLoop, GivesADeviceNoMoreTorqueThanItHas) {
  RecordingDevice device;
  ServoLoop loop(device, [](const DeviceSample&, double) {
    return Wrench{{1.0, 0.0, 0.0}, {0.0, 3.0, 4.0}};
  });
  loop.start();
  waitForTicks(loop, 20);
  loop.stop();
  EXPECT_NEAR(glm::length(device.largestTorque - glm::dvec3(0.0, 0.06, 0.08)), 0.0, 1e-12);
}

TEST(ServoLoop, TicksAndLeavesZeroForceOnStop) {
  RecordingDevice device;
  std::atomic<int> calls{0};
  ServoLoop loop(device, [&calls](const DeviceSample& sample, double now) {
    calls.fetch_add(1);
    EXPECT_TRUE(sample.valid);
    EXPECT_EQ(sample.time, now);
    return Wrench{{1.0, 0.0, 0.0}, {}};
  });
  loop.start();
  loop.start();  // once more does nothing
  waitForTicks(loop, 50);
  loop.stop();
  EXPECT_EQ(device.last.force, glm::dvec3(0.0, 0.0, 0.0));
  EXPECT_EQ(device.largest.load(), 1.0);
  EXPECT_EQ(calls.load(), device.polls.load());
  EXPECT_EQ(device.applied.load(), calls.load() + 1) << "one a tick, and the zero at the end";
  const int applied = device.applied.load();
  loop.stop();
  EXPECT_EQ(device.applied.load(), applied);
}

TEST(ServoLoop, DrivesTwoDevicesInOneThreadEachWithinItsLimits) {
  RecordingDevice first, second;
  ServoLoop loop(first, second, [](const std::array<DeviceSample, 2>& samples, double now) {
    EXPECT_TRUE(samples[0].valid && samples[1].valid);
    EXPECT_EQ(samples[1].time, now);
    return std::array<Wrench, 2>{Wrench{{1.0, 0.0, 0.0}, {}}, Wrench{{0.0, 50.0, 0.0}, {}}};
  });
  loop.start();
  waitForTicks(loop, 20);
  loop.stop();
  EXPECT_EQ(first.largest.load(), 1.0);
  EXPECT_NEAR(second.largest.load(), 3.0, 1e-12);
  EXPECT_EQ(first.polls.load(), second.polls.load());
  EXPECT_EQ(first.last.force, glm::dvec3(0.0));
  EXPECT_EQ(second.last.force, glm::dvec3(0.0));
}

TEST(ServoLoop, HoldsBothDevicesAtZeroForceWhenTheCallbackOverruns) {
  RecordingDevice first, second;
  ServoLoop loop(first, second, [&first, &second](const std::array<DeviceSample, 2>&, double) {
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
    first.largest = 0.0, second.largest = 0.0;  // what was before counts no more
    return std::array<Wrench, 2>{Wrench{{1.0, 0.0, 0.0}, {}}, Wrench{{1.0, 0.0, 0.0}, {}}};
  });
  loop.start();
  waitForTicks(loop, OverrunGuard::kLimit + 4);
  loop.stop();
  EXPECT_GT(loop.statistics().zeroed, 0u);
  EXPECT_EQ(first.largest.load(), 0.0);
  EXPECT_EQ(second.largest.load(), 0.0);
}

TEST(ServoLoop, StopsWithoutEverStartingAndStartsAgain) {
  RecordingDevice device;
  ServoLoop loop(device, [](const DeviceSample&, double) { return Wrench{}; });
  loop.stop();
  for (int i = 0; i < 2; ++i) {
    const std::uint64_t before = loop.statistics().ticks;
    loop.start();
    waitForTicks(loop, before + 5);
    loop.stop();
  }
  EXPECT_GE(loop.statistics().ticks, 10u);
}

TEST(ServoLoop, PassesOnlyFiniteForcesWithinTheDevicesLimits) {
  RecordingDevice device;
  std::atomic<int> calls{0};
  ServoLoop loop(device, [&calls](const DeviceSample&, double) {
    return calls.fetch_add(1) % 2 ? Wrench{{100.0, 0.0, 0.0}, {5.0, 0.0, 0.0}}
                                  : Wrench{{std::numeric_limits<double>::quiet_NaN(), 0.0, 0.0}, {}};
  });
  loop.start();
  waitForTicks(loop, 20);
  loop.stop();
  EXPECT_NEAR(device.largest.load(), 3.0, 1e-12);
}

TEST(ServoLoop, GivesZeroForceWhenTheCallbackThrows) {
  RecordingDevice device;
  ServoLoop loop(device, [](const DeviceSample&, double) -> Wrench { throw std::runtime_error("broken"); });
  loop.start();
  waitForTicks(loop, 5);
  loop.stop();
  EXPECT_EQ(device.largest.load(), 0.0);
  EXPECT_GE(loop.statistics().exceptions, 5u);
  EXPECT_NE(loop.statistics().note.find("threw"), std::string::npos);
}

TEST(ServoLoop, HoldsZeroForceAfterABrokenInvariantInTheCallback) {
  RecordingDevice device;
  std::atomic<int> calls{0};
  ServoLoop loop(device, [&](const DeviceSample&, double) {
    ASSERT(calls.fetch_add(1) != 2);
    return Wrench{{1.0, 0.0, 0.0}, {}};
  });
  loop.start();
  waitForTicks(loop, 6);
  const std::string note = loop.statistics().note;
  EXPECT_NE(note.find("broken invariant"), std::string::npos) << note;
  EXPECT_NE(note.find("servo_loop_test.cpp"), std::string::npos) << note;
  EXPECT_NE(loop.statistics().fault.find("servo_loop_test.cpp"), std::string::npos);
  EXPECT_GE(calls.load(), 6);
  EXPECT_EQ(device.largest.load(), 1.0);
  device.largest = 0.0;
  waitForTicks(loop, loop.statistics().ticks + 5);
  loop.stop();
  EXPECT_EQ(device.largest.load(), 0.0);
  loop.start();
  waitForTicks(loop, loop.statistics().ticks + 2);
  loop.stop();
  EXPECT_EQ(device.largest.load(), 1.0);
  EXPECT_EQ(loop.statistics().note.find("broken invariant"), std::string::npos);
  EXPECT_EQ(loop.statistics().fault, "");
}

TEST(ServoLoop, LetsGoWhenADriversInvariantBreaks) {
  struct Broken : RecordingDevice {
    DeviceSample poll(double now) override {
      ASSERT(polls.load() < 3);
      return RecordingDevice::poll(now);
    }
  } device;
  ServoLoop loop(device, [](const DeviceSample&, double) { return Wrench{{1.0, 0.0, 0.0}, {}}; });
  loop.start();
  while (device.applied.load() < 4) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  loop.stop();
  EXPECT_EQ(device.largest.load(), 1.0);
  EXPECT_EQ(device.last.force, glm::dvec3(0.0));
  EXPECT_NE(loop.statistics().note.find("polls.load() < 3"), std::string::npos);
}

TEST(ServoLoop, HoldsZeroForceWhenTheCallbackOverrunsEachTime) {
  RecordingDevice device;
  ServoLoop loop(device, [](const DeviceSample&, double) {
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
    return Wrench{{1.0, 0.0, 0.0}, {}};
  });
  loop.start();
  waitForTicks(loop, OverrunGuard::kLimit + 4);
  loop.stop();
  const ServoStatistics statistics = loop.statistics();
  EXPECT_EQ(statistics.zeroed, statistics.ticks - (OverrunGuard::kLimit - 1));
  EXPECT_GE(statistics.skipped, statistics.ticks);
  EXPECT_GE(statistics.compute_us_p50, 2000.0 * 0.93);
}

TEST(ServoLoop, SaysWhetherItIsRealtimeOrWhyNot) {
  RecordingDevice device;
  ServoLoop loop(device, [](const DeviceSample&, double) { return Wrench{}; });
  EXPECT_FALSE(loop.statistics().realtime) << "not before it has started";
  loop.start();
  waitForTicks(loop, 2);
  loop.stop();
  const ServoStatistics statistics = loop.statistics();
  EXPECT_EQ(statistics.note.find("real-time") == std::string::npos, statistics.realtime);
  EXPECT_EQ(statistics.note.find("memory") == std::string::npos, statistics.memoryLocked);
}

TEST(ServoLoop, FlushesDenormalsInItsThread) {
  RecordingDevice device;
  std::atomic<double> product{1.0};
  ServoLoop loop(device, [&product](const DeviceSample&, double) {
    volatile double tiny = std::numeric_limits<double>::min();
    product.store(tiny * 0.5);
    return Wrench{};
  });
  loop.start();
  waitForTicks(loop, 1);
  loop.stop();
#if defined(__x86_64__) || defined(__aarch64__)
  EXPECT_EQ(product.load(), 0.0);
#endif
}

TEST(ServoLoop, KeepsRecentComputeTimesForAPlot) {
  RecordingDevice device;
  ServoLoop loop(device, [](const DeviceSample&, double) { return Wrench{}; });
  EXPECT_EQ(loop.recentComputeTimes().back(), 0.0f);
  loop.start();
  waitForTicks(loop, 10);
  loop.stop();
  for (int i = 0; i < 10; ++i) EXPECT_GT(loop.recentComputeTimes()[255 - static_cast<std::size_t>(i)], 0.0f);
}

}  // namespace
}  // namespace tandem::haptics
