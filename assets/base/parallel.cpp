#include "assets/base/parallel.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace tandem {
namespace {

struct Failure {
  std::mutex mutex;
  std::size_t item = 0;
  std::exception_ptr exception;
  std::atomic<bool> any{false};

  void record(std::size_t i) {
    const std::lock_guard lock(mutex);
    if (!exception || i < item) {
      item = i;
      exception = std::current_exception();
    }
    any.store(true, std::memory_order_relaxed);
  }
};

}  // namespace

void parallelFor(std::size_t count, const std::function<void(std::size_t)>& work,
                 const std::function<void(std::size_t)>& progress) {
  std::atomic<std::size_t> next{0};
  Failure failure;
  // Items begin in order. When an item throws, every smaller item has begun already, so its exception is
  // recorded too.
  const auto run = [&](bool caller) {
    while (!failure.any.load(std::memory_order_relaxed)) {
      const std::size_t i = next.fetch_add(1, std::memory_order_relaxed);
      if (i >= count) return;
      try {
        if (caller && progress) progress(i);
        work(i);
      } catch (...) {
        failure.record(i);
      }
    }
  };
  const std::size_t cores = std::max(1u, std::thread::hardware_concurrency());
  std::vector<std::jthread> helpers;
  for (std::size_t i = 1; i < std::min(cores, count); ++i) helpers.emplace_back(run, false);
  run(true);
  helpers.clear();
  if (failure.exception) std::rethrow_exception(failure.exception);
}

}  // namespace tandem
