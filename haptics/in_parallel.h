#pragma once

// Equal shares of a loop, one a thread. For construction, never for ticks.
// An exception from the work, or a thread that cannot start, ends the program.

#include <algorithm>
#include <cstddef>
#include <thread>
#include <vector>

namespace tandem::haptics {

/// Calls work(begin, end, worker) for equal shares of `count`; returns when all are done.
template <typename Work>
void inParallel(std::size_t count, int workers, const Work& work) {
  std::vector<std::thread> helpers;
  const std::size_t share = count / static_cast<std::size_t>(workers) + 1;
  const auto run = [&](int worker) {
    const std::size_t begin = std::min(count, share * static_cast<std::size_t>(worker));
    work(begin, std::min(count, begin + share), worker);
  };
  for (int i = 1; i < workers; ++i) helpers.emplace_back(run, i);
  run(0);
  for (std::thread& helper : helpers) helper.join();
}

}  // namespace tandem::haptics
