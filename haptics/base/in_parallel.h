#pragma once

// Work on several threads at once. For construction, never for ticks. An exception from the work, or a thread
// that cannot start, ends the program.

#include <algorithm>
#include <cstddef>
#include <thread>
#include <vector>

namespace tandem::haptics {

/// Calls work(worker) on `workers` threads, at least one, of which the caller is number 0; returns when all
/// are done.
template <typename Work>
void onThreads(int workers, const Work& work) {
  std::vector<std::thread> helpers;
  for (int i = 1; i < workers; ++i) helpers.emplace_back([&work, i] { work(i); });
  work(0);
  for (std::thread& helper : helpers) helper.join();
}

/// Calls work(begin, end, worker) for equal shares of `count`; returns when all are done.
template <typename Work>
void inParallel(std::size_t count, int workers, const Work& work) {
  const std::size_t share = count / static_cast<std::size_t>(workers) + 1;
  onThreads(workers, [&](int worker) {
    const std::size_t begin = std::min(count, share * static_cast<std::size_t>(worker));
    work(begin, std::min(count, begin + share), worker);
  });
}

}  // namespace tandem::haptics
