#pragma once

// Plays out the states of a part that another site moves. They wait in a short buffer and are played out with
// a delay, so that jitter and losses do not reach the hand. The buffer interpolates between states (cubic
// Hermite, from positions and velocities), extrapolates for a bounded time, then holds the pose; corrections
// after an extrapolation are blended in.
//
// No allocation, so the haptic thread may use it. Times are session time.

#include <array>
#include <cstddef>

#include "sync/wire/state_update.h"
#include "sync/wire/time.h"

namespace tandem::sync {

/// The play-out delay D_p: a quantile of recent transits (arrival - state time), after Moon, Kurose and
/// Towsley, "Packet audio playout delay adjustment: performance bounds and algorithms", Multimedia Systems 6
/// (1998). The quantile is 98 %, kReserve is added, and the delay follows quickly up and slowly down.
class PlayOutDelay {
 public:
  /// A state that held at `stateTime` arrived at `arrival`.
  void observe(Micros stateTime, Micros arrival);
  /// The delay at `now`. It grows by at most half of the elapsed time and shrinks by at most 5 % of it, so
  /// playing runs at 0.5 to 1.05 times its speed and never backwards. 0 before the first state.
  Micros delay(Micros now);

  static constexpr Micros kReserve = 2 * kMillisecond;  // above the quantile of the delays

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
  /// An epoch began or ended: from now on the part is at this pose, to which the displayed pose blends within
  /// `blend` (0 = at once). Older states are forgotten (S6).
  void restart(const Pose& worldFromPart, Micros now, Micros blend);

  /// A state that ownership has accepted, holding at `time`. Out-of-order states within the buffer are sorted
  /// in.
  void push(const PartState& state, Micros time);

  struct Shown {
    Pose worldFromPart;
    Twist twist;
    bool extrapolated = false;
    bool still = true;  // at rest, and no newer state is known
  };
  /// The pose to display at session time `now`: that of `now - delay`.
  Shown at(Micros now, Micros delay);

  static constexpr Micros kMaxExtrapolation = 50 * kMillisecond;

 private:
  struct Entry {
    Micros time = 0;
    Pose pose;
    Twist twist;
  };
  /// Half a second at 250 Hz. When it is full, the oldest state is dropped.
  static constexpr std::size_t kCapacity = 128;

  /// The pose that the buffer alone gives for the time t, without the blend.
  Shown sample(Micros t) const;
  /// Adds the step from one pose to another to the offset that is being blended away; `rate` in 1/s, where 0
  /// chooses it by the size of the step.
  void blendStep(const Pose& from, const Pose& to, double rate);
  void decay(double dt);

  std::array<Entry, kCapacity> entries_{};  // sorted by time
  std::size_t count_ = 0;
  bool changed_ = false;  // since the last at()
  bool shownBefore_ = false;
  Micros shownAt_ = 0, playedAt_ = 0;  // arguments of the last at(): session time, and play time
  Pose raw_;                           // the pose of the last at(), without the blend
  // The blend: an offset (position, rotation vector) and its rate of change, critically damped toward zero.
  glm::dvec3 offset_{0.0, 0.0, 0.0}, offsetRate_{0.0, 0.0, 0.0};
  glm::dvec3 turn_{0.0, 0.0, 0.0}, turnRate_{0.0, 0.0, 0.0};
  double blendRate_ = 0.0;  // 1/s; 0 = nothing to blend
  double largestOffset_ = 0.0, largestTurn_ = 0.0;
};

}  // namespace tandem::sync
