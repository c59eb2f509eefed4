#include "haptics/base/tick_helpers.h"

#include <algorithm>

#include "assets/base/assert.h"

namespace tandem::haptics {
namespace {

constexpr std::uint64_t kTask = 0xffff;  // the bits of the index of the next task
constexpr int kCountAt = 16, kNumberAt = 32;

void pause() {
#if defined(__x86_64__) || defined(__i386__)
  __builtin_ia32_pause();
#elif defined(__aarch64__)
  asm volatile("yield");
#endif
}

}  // namespace

TickHelpers::TickHelpers(int count, const std::function<void()>& begin)
    : count_(std::clamp(count, 0, kMost)) {
  for (int i = 0; i < count_; ++i) {
    threads_[static_cast<std::size_t>(i)] = std::thread([this, i, begin] {
      if (begin) begin();
      watch(i + 1);
    });
  }
}

TickHelpers::~TickHelpers() {
  awake_.store(kEnding, std::memory_order_release);
  awake_.notify_all();
  for (std::thread& thread : threads_) {
    if (thread.joinable()) thread.join();
  }
}

void TickHelpers::wake() {
  awake_.store(kAwake, std::memory_order_release);
  awake_.notify_all();
}

void TickHelpers::watch(int worker) {
  for (;;) {
    awake_.wait(kAsleep, std::memory_order_acquire);
    int state = awake_.load(std::memory_order_acquire);
    for (; state == kAwake; state = awake_.load(std::memory_order_acquire)) {
      work(worker);
      pause();
    }
    if (state == kEnding) return;
  }
}

void TickHelpers::share(int tasks, Call call, const void* context) {
  ASSERT(tasks >= 0 && tasks <= kMostTasks);
  call_ = call;
  context_ = context;
  std::fegetenv(&mode_);
  ended_.store(0, std::memory_order_relaxed);
  failed_.store(false, std::memory_order_relaxed);
  const std::uint64_t number = (next_.load(std::memory_order_relaxed) >> kNumberAt) + 1;
  const std::uint64_t count = static_cast<std::uint64_t>(tasks) << kCountAt;
  next_.store(number << kNumberAt | count, std::memory_order_release);
  work(0);
  while (ended_.load(std::memory_order_acquire) < tasks) pause();
  if (failed_.load(std::memory_order_relaxed)) throw failure_;
}

void TickHelpers::work(int worker) {
  std::uint64_t shared = next_.load(std::memory_order_acquire);
  while ((shared & kTask) < (shared >> kCountAt & kTask)) {
    const bool taken = next_.compare_exchange_weak(shared, shared + 1, std::memory_order_acq_rel,
                                                   std::memory_order_acquire);
    if (!taken) continue;
    runTask(static_cast<int>(shared & kTask), worker);
    ended_.fetch_add(1, std::memory_order_acq_rel);
    shared = next_.load(std::memory_order_acquire);
  }
}

void TickHelpers::runTask(int task, int worker) {
  if (worker > 0) std::fesetenv(&mode_);
  const AssertionScope scope;
  try {
    call_(context_, task, worker);
  } catch (const FailedAssertion& failure) {
    // The first one is told; all helpers may fail at once.
    if (!failed_.exchange(true, std::memory_order_acq_rel)) failure_ = failure;
  }
}

}  // namespace tandem::haptics
