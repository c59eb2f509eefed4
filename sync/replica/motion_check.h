#pragma once

// Whether what an owner says of its part is a motion that a body in a hand can make. Four sums tell: the way
// and the turn that the stated velocities do not account for, and the changes of linear and of angular
// velocity. All shrink with time, so that collisions, lost datagrams and a corrected clock do not fill them.
//
// Pure, no clock: times are the owner's, of session time.

#include "sync/wire/state_update.h"
#include "sync/wire/time.h"

namespace tandem::sync {

/// Of a sum: what it may reach, and by how much it shrinks a second.
struct MotionSum {
  double most, shrinks;
};

struct MotionLimits {
  MotionSum way{0.1, 0.3};       // m: beside the mean velocity and `unseen`
  MotionSum turn{1.0, 5.0};      // rad: the same
  MotionSum change{6.0, 40.0};   // m/s
  MotionSum spin{80.0, 1000.0};  // rad/s
  double unseen = 20.0;          // m/s^2, of what may happen between two states
  double unseenTurn = 500.0;     // rad/s^2
};

class MotionCheck {
 public:
  /// Takes the next state of a part whose centre of mass is at `centre` in its frame, held at `time`. True
  /// if a sum passed its limit; all begin anew then.
  bool observe(const PartState& state, const glm::dvec3& centre, Micros time, const MotionLimits& limits);

  /// A later state than this says nothing about what came before.
  static constexpr Micros kLongest = 500 * kMillisecond;

 private:
  bool known_ = false;
  Epoch epoch_ = 0;
  Pose worldFromCentre_;
  Twist twist_;  // of the centre
  Micros time_ = 0;
  double way_ = 0.0, turn_ = 0.0, change_ = 0.0, spin_ = 0.0;
};

}  // namespace tandem::sync
