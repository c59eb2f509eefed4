#pragma once

// Forces of contacts and couplings that have ended, on their way to zero.

#include <glm/vec3.hpp>

#include "assets/base/pose.h"

namespace tandem::haptics {

/// A force (N; way in m) or torque (N·m; way in rad) that fades in a straight line over time, and as that of a
/// spring which lets go: it gives the hand no more than the energy F^2 / 2k that the spring held when it ended.
/// A hand that follows the force loses it at k per metre; one that goes against it does not raise it.
class Fading {
 public:
  /// Adds a force that ended in the last tick, and that a spring of this stiffness (N/m, N·m/rad) held.
  void start(const glm::dvec3& ended, double stiffness);

  /// `way` is what the hand went while the last tick's force was held, `timeShare` how much of the time is
  /// left, 0..1.
  void advance(const glm::dvec3& way, double timeShare);

  glm::dvec3 now() const { return from_ * share_; }

 private:
  glm::dvec3 from_{0.0, 0.0, 0.0};
  double share_ = 0.0;              // of from_
  double full_ = 0.0, left_ = 0.0;  // J: of the spring at from_, and what it may still give
};

/// Force and torque together, over one time.
class Fade {
 public:
  struct Stiffness {
    double linear = 0.0, angular = 0.0;  // N/m, N·m/rad
  };

  /// Adds a wrench that ended in the last tick; what still fades starts anew with it, over `time` s.
  void start(const Wrench& ended, const Stiffness& stiffness, double time);

  /// `way` and `turn` (rotation vector): what the hand went since the last tick, m and rad.
  void advance(const glm::dvec3& way, const glm::dvec3& turn, double dt);

  bool active() const { return left_ > 0.0; }
  Wrench now() const { return {force_.now(), torque_.now()}; }

 private:
  Fading force_, torque_;
  double left_ = 0.0, total_ = 0.0;  // s
};

}  // namespace tandem::haptics
