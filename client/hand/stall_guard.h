#pragma once

// Readings after a pause of the loop. A loop that stood still has lost its hold on the world: the hands are
// elsewhere, and the devices' own watchdogs have let go. One tick without a reading sets the force to zero;
// then a held part is grasped anew where part and device are now, and the tick puts the tool onto a hand that
// has moved on, which may be inside a part.
//
// Haptic thread.

#include <array>
#include <cstddef>

#include "haptics/base/tick_types.h"
#include "sync/wire/time.h"

namespace tandem::client {

class StallGuard {
 public:
  /// A gap between ticks as long as a device's own watchdog: the hand was without force meanwhile.
  static constexpr sync::Micros kStall = 50 * sync::kMillisecond;
  /// Without a reading for longer than a quarter of a second, the tick puts the proxy back onto the device.
  static constexpr int kReseatTicks = 300;

  /// Notes a tick at local time `now`; true if the loop stood still before it.
  bool noteTick(sync::Micros now) {
    stalled_ = lastTick_ != 0 && now - lastTick_ > kStall;
    lastTick_ = now;
    return stalled_;
  }
  /// Puts the first hand's tool back onto its device, without force meanwhile.
  void reseat() { reseatTicks_ = kReseatTicks; }

  struct Reading {
    haptics::DeviceSample sample;
    bool graspsAnew = false;  // the first good reading after a pause
  };
  /// What the tick is given for this reading of a hand, once a tick.
  Reading filter(haptics::DeviceSample sample, std::size_t hand) {
    if (hand == 0 && reseatTicks_ > 0) {
      --reseatTicks_;
      sample.valid = false;
    }
    if (stalled_) sample.valid = false;
    const bool graspsAnew = !stalled_ && graspAnew_[hand] && sample.valid;
    graspAnew_[hand] = stalled_ || (graspAnew_[hand] && !graspsAnew);
    return {sample, graspsAnew};
  }

 private:
  sync::Micros lastTick_ = 0;
  bool stalled_ = false;
  int reseatTicks_ = 0;  // ticks without a reading that are left until the tip is back on the device
  std::array<bool, haptics::kHands> graspAnew_{};
};

}  // namespace tandem::client
