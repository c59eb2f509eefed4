#pragma once

// Part commands that wait for a tick with room. The ring is as large as a session's parts, so a reset of all
// fits.
//
// Haptic thread; allocates in the constructor only.

#include <array>
#include <span>
#include <vector>

#include "assets/base/assert.h"
#include "haptics/base/tick_types.h"

namespace tandem::client {

class CommandQueue {
 public:
  explicit CommandQueue(std::size_t parts) : ring_(2 * parts + 64) {}

  bool empty() const { return count_ == 0; }
  /// Whether one more event may be handled: it causes fewer commands than a tick takes.
  bool hasRoom() const { return count_ + haptics::kMaxPartCommands < ring_.size(); }

  void push(haptics::PartCommand::Kind kind, PartId part, const Pose& pose = {}, std::uint8_t hand = 0,
            const Twist& twist = {}) {
    ASSERT(count_ < ring_.size());
    ring_[(first_ + count_) % ring_.size()] = {kind, part, pose, hand, twist};
    ++count_;
  }
  /// Removes the oldest commands, at most as many as a tick takes. Valid until the next call.
  std::span<const haptics::PartCommand> nextBatch() {
    std::size_t size = 0;
    for (; size < batch_.size() && count_ > 0; ++size, --count_) {
      batch_[size] = ring_[first_];
      first_ = (first_ + 1) % ring_.size();
    }
    return {batch_.data(), size};
  }

 private:
  std::vector<haptics::PartCommand> ring_;
  std::size_t first_ = 0, count_ = 0;
  std::array<haptics::PartCommand, haptics::kMaxPartCommands> batch_;
};

}  // namespace tandem::client
