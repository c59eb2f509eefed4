#pragma once

// Fades the forces of contacts and couplings that have ended to zero.

#include <glm/vec3.hpp>

#include "assets/base/pose.h"

namespace tandem::haptics {

/// A force (N, displacement in m) or torque (N·m, displacement in rad) that fades linearly over time, and
/// no later than that of a released spring: the hand receives at most the energy F^2 / 2k that the spring
/// stored when it ended. A hand that yields to the force lowers it at k per metre; a hand that moves
/// against it does not raise it.
class Fading {
 public:
  /// Adds a force that ended in the last tick and that a spring of this stiffness (N/m, N·m/rad) held.
  void start(const glm::dvec3& ended, double stiffness);

  /// `displacement` (m or rad) is the hand's while the last tick's force was held; `timeShare` is the
  /// fraction of time left, 0..1.
  void advance(const glm::dvec3& displacement, double timeShare);

  glm::dvec3 now() const { return from_ * share_; }

 private:
  glm::dvec3 from_{0.0, 0.0, 0.0};
  double share_ = 0.0;              // of from_
  double full_ = 0.0, left_ = 0.0;  // J: stored in the spring at from_, and left to the hand
};

/// Force and torque together, over one duration.
class Fade {
 public:
  struct Stiffness {
    double linear = 0.0, angular = 0.0;  // N/m, N·m/rad
  };

  /// Adds a wrench that ended in the last tick; what still fades restarts with it, over `time` s.
  void start(const Wrench& ended, const Stiffness& stiffness, double time);

  /// `displacement` (m) and `rotation` (rotation vector, rad) are the hand's since the last tick.
  void advance(const glm::dvec3& displacement, const glm::dvec3& rotation, double dt);

  bool active() const { return left_ > 0.0; }
  Wrench now() const { return {force_.now(), torque_.now()}; }

 private:
  Fading force_, torque_;
  double left_ = 0.0, total_ = 0.0;  // s
};

}  // namespace tandem::haptics
