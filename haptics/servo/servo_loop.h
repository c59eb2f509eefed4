#pragma once

// Servo loop: the 1 kHz thread that polls the device, calls the tick, applies the force and records the
// times.
//
// 1. Nothing in the loop allocates, locks or logs. SCHED_FIFO and mlockall are tried once and reported, never
//    required.
// 2. A late wake-up is counted and the schedule moves on, without a burst of catch-up ticks.
// 3. On stop, and while the callback overruns its period too often (servo_schedule.h), the device gets zero
//    force. A non-finite wrench counts as zero; one above the device's limits is shortened to them.
// 4. After a failed ASSERT the force is zero until the loop is started again. One in the callback lets the
//    callback run on; one in the loop itself or in a driver ends the thread.

#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <thread>

#include "haptics/base/device.h"
#include "haptics/base/duration_histogram.h"

namespace tandem::haptics {

/// Statistics of the loop so far; readable from any thread, but not during start().
struct ServoStatistics {
  std::uint64_t ticks = 0;
  std::uint64_t late = 0;        // woken more than half a period late
  std::uint64_t skipped = 0;     // periods left out because they had already passed
  std::uint64_t zeroed = 0;      // ticks at zero force because the callback overran its period too often
  std::uint64_t exceptions = 0;  // callbacks that threw
  double compute_us_p50 = 0.0, compute_us_p99 = 0.0, compute_us_max = 0.0;  // callback only, since start
  double period_us_p99 = 0.0, period_us_max = 0.0;
  bool realtime = false;  // SCHED_FIFO granted
  bool memoryLocked = false;
  std::string note;   // why not, and what went wrong, as text
  std::string fault;  // the broken invariant that holds the force at zero; empty: none
};

class ServoLoop {
 public:
  static constexpr double kUsualRate = 1000.0;  // Hz
  /// Returns the wrench to apply for a reading. `now` is seconds on the loop's monotonic clock
  /// (std::chrono::steady_clock).
  using Callback = std::function<Wrench(const DeviceSample& sample, double now)>;

  /// Callback for two devices of one person, polled and driven in one thread.
  using PairCallback = std::function<std::array<Wrench, 2>(const std::array<DeviceSample, 2>&, double now)>;

  ServoLoop(Device& device, Callback callback, double rate = kUsualRate);
  ServoLoop(Device& device, Device& second, PairCallback callback, double rate = kUsualRate);
  ~ServoLoop();  // stops

  /// Starts the thread, unless it runs already. The device must be open.
  void start();
  /// Stops the thread and leaves the device at zero force. Idempotent.
  void stop();
  ServoStatistics statistics() const;

  /// Compute times of all ticks since start(), as a copy to compare with a later one; any thread.
  DurationCounts computeTimes() const;

  /// Compute time of recent ticks for a live plot, us, oldest first; any thread.
  std::array<float, 256> recentComputeTimes() const;

  /// Gives the calling thread the loop's priority, SCHED_FIFO, as the loop may wait for it (TickHelpers).
  /// Returns 0, or the error number where it may not have it.
  static int becomeRealtime();

  /// Seconds on the clock of callbacks and samples.
  static double now();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace tandem::haptics
