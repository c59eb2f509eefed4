#pragma once

// Tells a hand at rest from one that moves slowly, by an encoder's reading alone.

#include <glm/vec3.hpp>

namespace tandem::haptics {

/// A reading that for some time has done nothing but stay and go back exactly to its last other value is an
/// encoder at a mark: the hand went far less than the quantum that the reading shows. An exact reading does
/// so only while it stands still.
class RestingReading {
 public:
  /// Notes the reading of a tick, m, of `dt` s. Whether each axis is at rest.
  bool note(const glm::dvec3& position, double dt) {
    bool returned = started_;
    for (int axis = 0; axis < 3; ++axis) {
      if (!started_) before_[axis] = position[axis];
      if (!started_ || position[axis] == last_[axis]) continue;
      returned = returned && position[axis] == before_[axis];
      before_[axis] = last_[axis];
    }
    started_ = true;
    last_ = position;
    resting_ = returned ? resting_ + dt : 0.0;
    return resting_ >= kResting;
  }

 private:
  // s: longer than the slowest swing that a wall at its limit makes of a quantum.
  static constexpr double kResting = 0.02;

  bool started_ = false;
  glm::dvec3 last_{0.0, 0.0, 0.0};    // m, the reading
  glm::dvec3 before_{0.0, 0.0, 0.0};  // m, the last other value of each axis
  double resting_ = 0.0;              // s
};

}  // namespace tandem::haptics
