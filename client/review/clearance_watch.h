#pragma once

// How near the part in the hand is to its nearest neighbour, measured in a thread of its own while the part
// is moved: never in the tick, and never so often that it takes more than a quarter of a core.
//
// 1. All methods are for one thread, which never waits for a measurement, but for the destructor.

#include <memory>
#include <optional>
#include <vector>

#include "client/review/clash_check.h"

namespace tandem::client {

class ClearanceWatch {
 public:
  /// The geometry must outlive this, and its meshes must not change.
  explicit ClearanceWatch(const haptics::ContactScene& contact);
  ~ClearanceWatch();
  ClearanceWatch(const ClearanceWatch&) = delete;
  ClearanceWatch& operator=(const ClearanceWatch&) = delete;

  /// The nearest neighbour of `part` among parts that may collide with it, of the last measurement; none until
  /// there is one. Starts the next with these poses (one a part) if the last was ready and long enough ago,
  /// about ten times a second. kNoPart forgets all.
  std::optional<Clash> update(PartId part, const std::vector<Pose>& worldFromPart);

 private:
  class Worker;
  std::unique_ptr<Worker> worker_;
};

}  // namespace tandem::client
