#pragma once

// Shows the states of a part that others move: a short buffer played out a little late, so that jitter and losses do not
// reach the hand or the eye. Interpolates between states (cubic Hermite, from positions and velocities), extrapolates
// for a bounded time, then stands still; corrections after an extrapolation are blended in.
//
// No allocation: may live in the haptic thread. Times are session time.

#include <array>
#include <cstddef>

#include "sync/messages.h"

namespace tandem::sync {

/// How late to play: follows the delay of arrivals, quickly up and slowly down. D_p = delay at a high quantile + 2 ms.
class PlayOutDelay {
 public:
  /// A state that held at `stateTime` arrived at `arrival`.
  void observe(Micros stateTime, Micros arrival);
  /// The delay at `now`; changes by at most 5 % of the elapsed time, so that playing never runs backwards.
  Micros delay(Micros now);

 private:
  static constexpr std::size_t kWindow = 128;
  std::array<Micros, kWindow> transit_{};
  std::size_t count_ = 0, next_ = 0;
  double target_us_ = 0.0, current_us_ = 0.0;
  Micros last_ = 0;
  bool started_ = false;
};

class PlayOut {
 public:
  /// A new epoch or the end of one: from now on the part is at this pose, reached from the shown pose by a blend of
  /// `blend` (0 = at once). Older states are forgotten (S6).
  void restart(const Pose& worldFromPart, Micros now, Micros blend);

  /// A state that ownership has accepted, holding at `time`. Out-of-order states within the buffer are sorted in.
  void push(const PartState& state, Micros time);

  struct Shown {
    Pose worldFromPart;
    Twist twist;
    bool extrapolated = false;
    bool still = true;   // nothing newer, not moving
  };
  /// What to show at session time `now`, playing at `now - delay`.
  Shown at(Micros now, Micros delay);

  static constexpr Micros kMaxExtrapolation = 50 * kMillisecond;

 private:
  struct Entry {
    Micros time = 0;
    Pose pose;
    Twist twist;
  };
  static constexpr std::size_t kCapacity = 64;
  std::array<Entry, kCapacity> entries_{};
  std::size_t count_ = 0;
  Pose blendFrom_, lastShown_;
  Micros blendStart_ = 0, blendLength_ = 0;
  bool shownBefore_ = false;
};

}  // namespace tandem::sync
