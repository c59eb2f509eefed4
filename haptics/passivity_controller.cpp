#include "haptics/passivity_controller.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

namespace tandem::haptics {
namespace {

constexpr double kResting =
    0.02;  // s: longer than the slowest swing that a wall at its limit makes of a quantum

}  // namespace

glm::dvec3 PassivityController::step(const glm::dvec3& position, const glm::dvec3& force, double damping,
                                     double dt) {
  const glm::dvec3 way = started_ ? position - position_ : glm::dvec3(0.0);
  const glm::dvec3 change = force - rendered_;
  const double square = glm::dot(way, way);
  const bool flickers = noteReading(position, dt);
  started_ = true;
  position_ = position;
  if (flickers) {
    rendered_ = force;
    return glm::dvec3(0.0);
  }
  if (square > 0.0) {
    const double given = glm::dot(sent_ - rendered_ - 0.5 * change, way);
    deficit_ = std::max(0.0, deficit_ + given - damping * square / dt);
  }
  rendered_ = force;
  if (!(square > 0.0) || !(deficit_ > 0.0)) return glm::dvec3(0.0);
  const glm::dvec3 against = way * (-deficit_ / square);
  double share = 1.0;
  const double most = glm::length(change), size = glm::length(against);
  if (size > most) share = most / size;
  // The sum may press less, but not pull.
  const double pull = -glm::dot(against, force) * share, press = glm::dot(force, force);
  if (pull > press) share *= press / pull;
  // Rounding of the force is not energy.
  return share * size > 0x1p-32 * std::sqrt(press) ? against * share : glm::dvec3(0.0);
}

bool PassivityController::noteReading(const glm::dvec3& position, double dt) {
  bool returned = started_;
  for (int axis = 0; axis < 3; ++axis) {
    if (!started_) before_[axis] = position[axis];
    if (!started_ || position[axis] == position_[axis]) continue;
    returned = returned && position[axis] == before_[axis];
    before_[axis] = position_[axis];
  }
  resting_ = returned ? resting_ + dt : 0.0;
  return resting_ >= kResting;
}

}  // namespace tandem::haptics
