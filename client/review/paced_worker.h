#pragma once

// One kind of work in a thread of its own, so rarely that it takes no more than a quarter of a core.
//
// 1. All methods are for one thread; `work` runs in the worker's. Only the destructor waits for it.
// 2. A request that is begun is finished, and its result kept until it is taken or the next one is there.

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include "assets/base/thread_priority.h"

namespace tandem::client {

template <typename Request, typename Answer>
class PacedWorker {
 public:
  struct Result {
    Request request;
    Answer answer;
  };

  /// Work begins at most once in a `period`.
  PacedWorker(std::chrono::milliseconds period, std::function<Answer(const Request&)> work)
      : period_(period), work_(std::move(work)), thread_([this] { run(); }) {}

  ~PacedWorker() {
    {
      const std::lock_guard lock(mutex_);
      stop_ = true;
    }
    wake_.notify_one();
    thread_.join();
  }
  PacedWorker(const PacedWorker&) = delete;
  PacedWorker& operator=(const PacedWorker&) = delete;

  /// Nothing is asked for or being done, and the pause after the last work is over.
  bool isReady() const {
    const std::lock_guard lock(mutex_);
    return !request_ && !busy_ && Clock::now() >= due_;
  }
  void ask(Request request) {
    {
      const std::lock_guard lock(mutex_);
      request_ = std::move(request);
    }
    wake_.notify_one();
  }
  /// Drops a request that is not begun.
  void drop() {
    const std::lock_guard lock(mutex_);
    request_.reset();
  }
  void endPause() {
    const std::lock_guard lock(mutex_);
    due_ = {};
  }
  /// What was finished since the last call.
  std::optional<Result> take() {
    const std::lock_guard lock(mutex_);
    return std::exchange(result_, std::nullopt);
  }

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr int kPause = 3;  // before the next work, in durations of the last one

  void run() {
    lowerThreadPriority();
    std::unique_lock lock(mutex_);
    while (true) {
      wake_.wait(lock, [this] { return stop_ || request_; });
      if (stop_) return;
      Request request = std::move(*request_);
      request_.reset();
      busy_ = true;
      lock.unlock();
      const Clock::time_point start = Clock::now();
      Answer answer = work_(request);
      const Clock::time_point end = Clock::now();
      lock.lock();
      busy_ = false;
      due_ = std::max(start + period_, end + kPause * (end - start));
      result_ = Result{std::move(request), std::move(answer)};
    }
  }

  const std::chrono::milliseconds period_;
  const std::function<Answer(const Request&)> work_;
  mutable std::mutex mutex_;
  std::condition_variable wake_;
  bool stop_ = false, busy_ = false;
  std::optional<Request> request_;
  std::optional<Result> result_;
  Clock::time_point due_{};
  std::thread thread_;  // last member, since it uses all of the above
};

}  // namespace tandem::client
