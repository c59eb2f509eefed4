#include "client/review/clearance_watch.h"

#include "assets/base/assert.h"
#include "client/review/paced_worker.h"

namespace tandem::client {

class ClearanceWatch::Worker {
 public:
  explicit Worker(const haptics::ContactScene& contact) : closings_(contact) {}

  std::optional<Clash> update(PartId part, const std::vector<Pose>& worldFromPart) {
    ASSERT(part == kNoPart || part < worldFromPart.size());
    const auto result = worker_.take();
    if (result && result->request.part == part) answer_ = result->answer;
    if (part != part_) answer_.reset();
    part_ = part;
    if (part == kNoPart) worker_.drop();
    if (part != kNoPart && worker_.isReady()) worker_.ask({part, worldFromPart});
    return answer_;
  }

 private:
  struct Request {
    PartId part;
    std::vector<Pose> worldFromPart;
  };
  static constexpr std::chrono::milliseconds kPeriod{100};

  const PartClosings closings_;
  PartId part_ = kNoPart;
  std::optional<Clash> answer_;
  PacedWorker<Request, std::optional<Clash>> worker_{
      kPeriod, [this](const Request& of) { return nearestPart(closings_, of.part, of.worldFromPart); }};
};

ClearanceWatch::ClearanceWatch(const haptics::ContactScene& contact)
    : worker_(std::make_unique<Worker>(contact)) {}
ClearanceWatch::~ClearanceWatch() = default;

std::optional<Clash> ClearanceWatch::update(PartId part, const std::vector<Pose>& worldFromPart) {
  return worker_->update(part, worldFromPart);
}

}  // namespace tandem::client
