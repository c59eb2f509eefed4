#include "client/findings/measure_watch.h"

#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <thread>
#include <utility>

#include "assets/base/assert.h"
#include "client/review/part_closings.h"

namespace tandem::client {

namespace {

using Clock = std::chrono::steady_clock;
using document::Anchor;
constexpr auto kPeriod = std::chrono::milliseconds(50);
constexpr int kRest = 3;            // pause before the next measurement, in durations of the last one
constexpr int kWatchNiceness = 10;  // the hand's thread comes first

bool same(const std::vector<Anchor>& a, const std::vector<Anchor>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const Anchor& one, const Anchor& other) {
    return one.part == other.part && one.point == other.point;
  });
}
bool same(const Pose& a, const Pose& b) { return a.position == b.position && a.orientation == b.orientation; }

}  // namespace

class MeasureWatch::Worker {
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

  struct Answer {
    std::vector<MeasuredPlace> places;  // in the frames of their parts
    std::optional<Clash> parts;
  };

  Answer update(const std::vector<Anchor>& marks, const std::vector<Pose>& worldFromPart) {
    const std::lock_guard lock(mutex_);
    std::vector<Pose> poses;
    for (const Anchor& mark : marks) poses.push_back(worldFromPart[mark.part]);
    if (!same(marks, marks_)) {
      marks_ = marks;
      answer_ = {};
      measured_.clear();
      due_ = {};
      requested_ = false;
    }
    const bool stale =
        measured_.size() != poses.size() || (marks.size() == 2 && marks[0].part != marks[1].part &&
                                             !(same(poses[0], measured_[0]) && same(poses[1], measured_[1])));
    if (stale && !requested_ && !busy_ && Clock::now() >= due_) {
      poses_ = std::move(poses);
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
      const std::vector<Anchor> marks = marks_;
      const std::vector<Pose> poses = poses_;
      std::vector<MeasuredPlace> places = answer_.places;
      lock.unlock();
      const Clock::time_point start = Clock::now();
      Answer answer = measure(marks, poses, std::move(places));
      const Clock::time_point end = Clock::now();
      lock.lock();
      busy_ = false;
      due_ = std::max(start + kPeriod, end + kRest * (end - start));
      if (!same(marks, marks_)) {
        due_ = {};
      } else {
        answer_ = std::move(answer);
        measured_ = poses;
      }
    }
  }

  /// `places` are those of an earlier measurement of these marks, or none.
  Answer measure(const std::vector<Anchor>& marks, const std::vector<Pose>& poses,
                 std::vector<MeasuredPlace> places) const {
    if (places.empty())
      for (const Anchor& mark : marks)
        if (const auto place = measurePlaceOn(closings_.contact(), mark.part, mark.point))
          places.push_back(*place);
    if (marks.size() < 2 || marks[0].part == marks[1].part) return {std::move(places), std::nullopt};
    return {std::move(places), measurePair(closings_, marks[0].part, poses[0], marks[1].part, poses[1])};
  }

  const PartClosings closings_;
  std::mutex mutex_;
  std::condition_variable wake_;
  bool stop_ = false, requested_ = false, busy_ = false;
  std::vector<Anchor> marks_;
  std::vector<Pose> poses_;     // of the marks' parts, for the requested measurement
  std::vector<Pose> measured_;  // the same of the last one; empty before it
  Answer answer_;
  Clock::time_point due_{};
  std::thread thread_;  // last member, since it uses all of the above
};

MeasureWatch::MeasureWatch(const haptics::ContactScene& contact) : contact_(contact) {}
MeasureWatch::~MeasureWatch() = default;

MeasureView MeasureWatch::update(const std::vector<Anchor>& marks, const std::vector<Pose>& worldFromPart) {
  ASSERT(marks.size() <= 2 && worldFromPart.size() == contact_.scene().parts.size());
  MeasureView view;
  view.possible = true;
  if (marks.empty() && !worker_) return view;
  for (const Anchor& mark : marks) ASSERT(mark.part < worldFromPart.size());
  if (!worker_) worker_ = std::make_unique<Worker>(contact_);
  Worker::Answer answer = worker_->update(marks, worldFromPart);
  for (const MeasuredPlace& place : answer.places)
    view.places.push_back(moved(place, worldFromPart[place.part]));
  view.parts = std::move(answer.parts);
  view.figures = figuresOf(view.places, view.parts);
  return view;
}

}  // namespace tandem::client
