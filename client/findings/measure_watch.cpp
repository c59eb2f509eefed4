#include "client/findings/measure_watch.h"

#include <algorithm>
#include <utility>

#include "assets/base/assert.h"
#include "client/review/paced_worker.h"
#include "client/review/part_closings.h"

namespace tandem::client {

namespace {

using document::Anchor;

bool same(const std::vector<Anchor>& a, const std::vector<Anchor>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const Anchor& one, const Anchor& other) {
    return one.part == other.part && one.point == other.point;
  });
}
bool same(const Pose& a, const Pose& b) { return a.position == b.position && a.orientation == b.orientation; }

}  // namespace

class MeasureWatch::Worker {
 public:
  explicit Worker(const haptics::ContactScene& contact) : closings_(contact) {}

  struct Answer {
    std::vector<MeasuredPlace> places;  // in the frames of their parts
    std::optional<Clash> parts;
  };

  const Answer& update(const std::vector<Anchor>& marks, const std::vector<Pose>& worldFromPart) {
    std::vector<Pose> poses;
    for (const Anchor& mark : marks) poses.push_back(worldFromPart[mark.part]);
    if (!same(marks, marks_)) {
      marks_ = marks;
      answer_ = {};
      measured_.clear();
      worker_.drop();
      worker_.endPause();
    }
    if (auto result = worker_.take()) keep(std::move(*result));
    const bool stale =
        measured_.size() != poses.size() || (marks.size() == 2 && marks[0].part != marks[1].part &&
                                             !(same(poses[0], measured_[0]) && same(poses[1], measured_[1])));
    if (stale && worker_.isReady()) worker_.ask({marks, std::move(poses), answer_.places});
    return answer_;
  }

 private:
  struct Request {
    std::vector<Anchor> marks;
    std::vector<Pose> poses;            // of the marks' parts
    std::vector<MeasuredPlace> places;  // those of an earlier measurement of these marks, or none
  };
  using Measurements = PacedWorker<Request, Answer>;
  static constexpr std::chrono::milliseconds kPeriod{50};

  void keep(Measurements::Result result) {
    if (!same(result.request.marks, marks_)) return worker_.endPause();
    answer_ = std::move(result.answer);
    measured_ = std::move(result.request.poses);
  }

  Answer measure(const Request& of) const {
    std::vector<MeasuredPlace> places = of.places;
    if (places.empty())
      for (const Anchor& mark : of.marks)
        if (const auto place = measurePlaceOn(closings_.contact(), mark.part, mark.point))
          places.push_back(*place);
    if (of.marks.size() < 2 || of.marks[0].part == of.marks[1].part) return {std::move(places), std::nullopt};
    return {std::move(places),
            measurePair(closings_, of.marks[0].part, of.poses[0], of.marks[1].part, of.poses[1])};
  }

  const PartClosings closings_;
  std::vector<Anchor> marks_;
  std::vector<Pose> measured_;  // of the marks' parts in the last measurement; empty before it
  Answer answer_;
  Measurements worker_{kPeriod, [this](const Request& of) { return measure(of); }};
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
  const Worker::Answer& answer = worker_->update(marks, worldFromPart);
  for (const MeasuredPlace& place : answer.places)
    view.places.push_back(moved(place, worldFromPart[place.part]));
  view.parts = answer.parts;
  view.figures = figuresOf(view.places, view.parts);
  return view;
}

}  // namespace tandem::client
