#pragma once

// Threads that share the work of one tick, each on a core that would be idle.
//
// 1. While an Awake lives they watch for tasks, without sleeping, so that they begin within a microsecond;
//    otherwise they sleep. run() waits for no helper that has not begun a task, so that one that is late, or
//    has no core, costs nothing.
// 2. A task runs with the floating-point mode of the thread that shares it, and a failed ASSERT in it is
//    thrown by run(), as it would have been without helpers.
// 3. Free of allocation and locks after construction; to wake them is a system call where one sleeps.

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

  /// Keeps helpers awake, each of which takes a core meanwhile; null: none.
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
  // What is shared: its number, the count of its tasks and the next one to take. Who has taken a task may
  // read what follows, because nothing else is shared before all tasks have ended.
  std::atomic<std::uint64_t> next_{0};
  std::atomic<int> ended_{0};
  Call call_ = nullptr;
  const void* context_ = nullptr;
  std::fenv_t mode_{};
  std::atomic<bool> failed_{false};
  FailedAssertion failure_;
};

}  // namespace tandem::haptics
