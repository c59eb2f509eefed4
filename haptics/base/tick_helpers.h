#pragma once

// A pool of threads that run parts of one tick in parallel, each on a core that would be idle.
//
// 1. While an object of the class Awake exists the threads busy-wait for tasks, so that they begin one
//    within a microsecond; otherwise they sleep. They and the calling thread take tasks until none is left.
//    run() waits for tasks that have begun: a thread that wakes late costs nothing, and one that loses its
//    core in the middle of a task delays run().
// 2. A task runs with the floating-point environment of the calling thread. A failed ASSERT in it is thrown
//    by run() in the calling thread.
// 3. Nothing allocates or locks after construction. Waking a thread that sleeps is a system call (futex).

#include <array>
#include <atomic>
#include <cfenv>
#include <cstdint>
#include <functional>
#include <thread>

#include "assets/base/assertion_scope.h"

namespace tandem::haptics {

class TickHelpers {
 public:
  static constexpr int kMost = 3;

  /// Starts so many threads, at most kMost, each of which calls `begin` first.
  explicit TickHelpers(int count, const std::function<void()>& begin = {});
  ~TickHelpers();
  TickHelpers(const TickHelpers&) = delete;
  TickHelpers& operator=(const TickHelpers&) = delete;

  int count() const { return count_; }

  // By one thread at a time.

  /// Wakes the threads of a pool and keeps them busy-waiting until it is destroyed; null: does nothing.
  class Awake {
   public:
    explicit Awake(TickHelpers* helpers) : helpers_(helpers) {
      if (helpers_ != nullptr) helpers_->wake();
    }
    ~Awake() {
      if (helpers_ != nullptr) helpers_->awake_.store(kAsleep, std::memory_order_release);
    }
    Awake(const Awake&) = delete;
    Awake& operator=(const Awake&) = delete;

   private:
    TickHelpers* helpers_;
  };

  /// Calls f(task, worker) once for each task, at most kMostTasks, and returns when all have ended. Worker 0
  /// is the calling thread; 1 to count() are helpers.
  template <typename F>
  void run(int tasks, const F& f) {
    share(
        tasks, [](const void* of, int task, int worker) { (*static_cast<const F*>(of))(task, worker); }, &f);
  }
  static constexpr int kMostTasks = 0xffff;

 private:
  using Call = void (*)(const void* context, int task, int worker);
  static constexpr int kAsleep = 0, kAwake = 1, kEnding = 2;

  void wake();
  void share(int tasks, Call call, const void* context);
  /// Takes tasks until none is left.
  void work(int worker);
  void runTask(int task, int worker);
  void watch(int worker);

  std::array<std::thread, kMost> threads_;
  int count_ = 0;
  std::atomic<int> awake_{kAsleep};
  // Of the present call of run(): its number, the count of its tasks and the index of the next one to take,
  // from the highest bits to the lowest. A thread that has taken a task may read the members below, because
  // run() does not return, and so is not called again, before all its tasks have ended.
  std::atomic<std::uint64_t> next_{0};
  std::atomic<int> ended_{0};
  Call call_ = nullptr;
  const void* context_ = nullptr;
  std::fenv_t mode_{};
  std::atomic<bool> failed_{false};
  FailedAssertion failure_;
};

}  // namespace tandem::haptics
