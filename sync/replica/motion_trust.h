#pragma once

// Whether a part that another site moves moves as a hand may move it, judged tick by tick by the poses that
// this site plays out. What a hand feels of a part that does not is limited (haptics/safety/foreign_guard.h).
//
// 1. A part gains speed, or turns its velocity, no faster than hand and device accelerate its mass. Less
//    speed is possible at any rate, because a part may hit something.
// 2. Play-out itself makes steps of velocity where packets are late or lost. They are no larger than the
//    speeds that the part has had shortly before, so a share of those is forgiven.
// 3. Where one of both is broken the part is suspect, in this tick already and for kSuspects after the last.
// 4. Being suspect accuses nobody: a part that jumps to where its new owner has it is so too. A part is
//    impossible, and its owner may be named, if within some seconds it has often gained more speed in excess
//    of the first rule than it can have reached by it.
//
// No allocation, so the haptic thread may use it.

#include "assets/base/pose.h"
#include "sync/wire/time.h"

namespace tandem::sync {

class MotionTrust {
 public:
  static constexpr double kMaxSpeed = 7.0;          // m/s, of a hand
  static constexpr double kMaxForce = 10.0;         // N, on a part, of a grasp's spring
  static constexpr double kMaxAcceleration = 40.0;  // m/s^2, of a hand, and of what falls
  static constexpr double kSlack = 0.02;            // m/s of steps that are forgiven at any time
  static constexpr double kShare = 0.5;             // of the speed that the part has had
  static constexpr double kRemembers = 0.5;         // s, time constant of that speed
  static constexpr double kForgives = 0.2;          // s, time constant of what has been forgiven
  static constexpr double kJump = 0.5e-3;           // m, beside what the speed explains within kJumpTime
  static constexpr double kJumpTime = 0.5;          // s
  static constexpr double kSuspects = 2.0;          // s
  static constexpr double kGross = 0.05;            // m/s in excess that accuse nobody, besides
  static constexpr double kGrossShare = 0.7;        // of the speed that the part can have reached
  static constexpr double kMostAtOnce = 3.0;        // breaches that one counts for by its size
  static constexpr double kForgets = 2.0;           // breaches a second
  static constexpr double kImpossible = 20.0;       // breaches

  /// `mass` kg, <= 0: unknown. `radius` m: of the part about its origin.
  MotionTrust() = default;
  MotionTrust(double mass, double radius, const Pose& worldFromPart);

  /// The part is shown at this pose, `dt` s after the last one. True while it is suspect.
  bool advance(const Pose& worldFromPart, double dt);
  /// The part is to be at another pose from now on, as its owner changed: the way there must be explained by
  /// the speed of late.
  void jump(const Pose& from, const Pose& to);
  /// This site has moved the part until now, at up to this speed (m/s).
  void remember(double speed) { speed_ = speed; }
  bool suspect() const { return suspects_ > 0.0; }
  bool impossible() const { return breaches_ >= kImpossible; }

 private:
  struct Velocity {
    glm::dvec3 linear{0.0, 0.0, 0.0}, atRadius{0.0, 0.0, 0.0};  // m/s
  };
  void accuse(double speed, double step, double dt);
  Velocity velocityTo(const Pose& worldFromPart, double dt) const;

  double acceleration_ = kMaxAcceleration, radius_ = 0.0;
  Pose last_;
  Velocity velocity_;
  double speed_ = 0.0;     // m/s, the largest of late, as far as it was reached by acceleration
  double forgiven_ = 0.0;  // m/s, of steps of velocity of late
  double suspects_ = 0.0;  // s for which the part is still suspect
  double reached_ = 0.0;   // m/s, as speed_, but of suspect motion too
  double gained_ = 0.0;    // m/s, as forgiven_, that have not counted as a breach
  double breaches_ = 0.0;  // of late
};

}  // namespace tandem::sync
