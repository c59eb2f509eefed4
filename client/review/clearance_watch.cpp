#include "client/review/clearance_watch.h"

#include <sys/resource.h>

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <thread>

#include "assets/base/assert.h"

namespace tandem::client {

namespace {

using Clock = std::chrono::steady_clock;
constexpr auto kPeriod = std::chrono::milliseconds(100);
constexpr int kRest = 3;            // pause before the next measurement, in durations of the last one
constexpr int kWatchNiceness = 10;  // the hand's thread comes first

}  // namespace

class ClearanceWatch::Worker {
 public:
  explicit Worker(const haptics::ContactScene& contact) : closings_(contact), thread_([this] { run(); }) {}

  ~Worker() {
    {
      const std::lock_guard lock(mutex_);
      stop_ = true;
    }
    wake_.notify_one();
    thread_.join();
  }

  std::optional<Clash> update(PartId part, const std::vector<Pose>& worldFromPart) {
    ASSERT(part == kNoPart || part < worldFromPart.size());
    const std::lock_guard lock(mutex_);
    if (part != part_) answer_.reset();
    part_ = part;
    if (part == kNoPart) requested_ = false;
    if (part != kNoPart && !requested_ && !busy_ && Clock::now() >= due_) {
      poses_ = worldFromPart;
      requested_ = true;
      wake_.notify_one();
    }
    return answer_;
  }

 private:
  void run() {
    // On Linux this sets the priority of this thread alone. If it fails, the thread has the usual priority.
    static_cast<void>(setpriority(PRIO_PROCESS, 0, kWatchNiceness));
    std::unique_lock lock(mutex_);
    while (true) {
      wake_.wait(lock, [this] { return stop_ || requested_; });
      if (stop_) return;
      requested_ = false;
      busy_ = true;
      const PartId part = part_;
      const std::vector<Pose> poses = std::move(poses_);
      lock.unlock();
      const Clock::time_point start = Clock::now();
      const std::optional<Clash> found = nearestPart(closings_, part, poses);
      const Clock::time_point end = Clock::now();
      lock.lock();
      busy_ = false;
      due_ = std::max(start + kPeriod, end + kRest * (end - start));
      if (part == part_) answer_ = found;
    }
  }

  const PartClosings closings_;
  std::mutex mutex_;
  std::condition_variable wake_;
  bool stop_ = false, requested_ = false, busy_ = false;
  PartId part_ = kNoPart;
  std::vector<Pose> poses_;  // one a part, for the requested measurement
  std::optional<Clash> answer_;
  Clock::time_point due_{};
  std::thread thread_;  // last member, since it uses all of the above
};

ClearanceWatch::ClearanceWatch(const haptics::ContactScene& contact)
    : worker_(std::make_unique<Worker>(contact)) {}
ClearanceWatch::~ClearanceWatch() = default;

std::optional<Clash> ClearanceWatch::update(PartId part, const std::vector<Pose>& worldFromPart) {
  return worker_->update(part, worldFromPart);
}

}  // namespace tandem::client
