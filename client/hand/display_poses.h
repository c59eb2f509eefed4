#pragma once

// Poses of parts on their way to the window and to traces. A full ring means a window that stands still; once
// a pose was dropped, one part a tick is sent again, so the window catches up.
//
// Haptic thread.

#include "client/session/exchange.h"
#include "haptics/tick.h"

namespace tandem::client {

class DisplayPoses {
 public:
  /// What is referred to must outlive this. `parts` of the scene.
  DisplayPoses(Exchange& exchange, const haptics::TickState& state, std::size_t parts)
      : exchange_(exchange), state_(state), parts_(parts) {}

  void push(const ShownPose& shown) { dropped_ += exchange_.shown.push(shown) ? 0 : 1; }
  /// The part as the tick has it.
  void pushAsItIs(PartId part, sync::Micros sessionNow) {
    const Pose& pose = state_.worldFromPart(part);
    push({part, false, sessionNow, pose, pose});
  }
  /// Once a tick.
  void refreshOne() {
    if (dropped_ == 0) return;
    pushAsItIs(next_, 0);
    next_ = static_cast<PartId>((next_ + 1u) % parts_);
  }

 private:
  Exchange& exchange_;
  const haptics::TickState& state_;
  std::size_t parts_;
  std::uint64_t dropped_ = 0;
  PartId next_ = 0;
};

}  // namespace tandem::client
