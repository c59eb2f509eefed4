#pragma once

// Measures the clearance between the held part and its nearest neighbour in a thread of its own, so rarely
// that it takes no more than a quarter of a core.
//
// 1. All methods are for one thread. Only the destructor waits for a measurement.

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

  /// The nearest neighbour of `part`, among parts that may collide with it, in the last measurement; nothing
  /// before the first one. Starts the next measurement with these poses (one a part) about ten times a
  /// second. kNoPart discards the last measurement.
  std::optional<Clash> update(PartId part, const std::vector<Pose>& worldFromPart);

 private:
  class Worker;
  std::unique_ptr<Worker> worker_;
};

}  // namespace tandem::client
