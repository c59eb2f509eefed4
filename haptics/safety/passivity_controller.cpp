#include "haptics/safety/passivity_controller.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

namespace tandem::haptics {

glm::dvec3 PassivityController::step(const glm::dvec3& position, const glm::dvec3& force,
                                     const glm::dvec3& byTime, double damping, double dt) {
  const glm::dvec3 displacement = started_ ? position - position_ : glm::dvec3(0.0);
  const glm::dvec3 change = force - rendered_ - byTime;
  const double square = glm::dot(displacement, displacement);
  const bool flickers = reading_.note(position, dt);
  started_ = true;
  position_ = position;
  if (flickers) {
    rendered_ = force;
    return glm::dvec3(0.0);
  }
  if (square > 0.0) {
    const double given = glm::dot(sent_ - rendered_ - 0.5 * change, displacement);
    deficit_ = std::max(0.0, deficit_ + given - damping * square / dt);
  }
  rendered_ = force;
  if (!(square > 0.0) || !(deficit_ > 0.0)) return glm::dvec3(0.0);
  const glm::dvec3 against = displacement * (-deficit_ / square);
  double share = 1.0;
  const double most = glm::length(change), size = glm::length(against);
  if (size > most) share = most / size;
  // The sum may press less, but not pull.
  const double pull = -glm::dot(against, force) * share, press = glm::dot(force, force);
  if (pull > press) share *= press / pull;
  // Rounding of the force is not energy.
  return share * size > 0x1p-32 * std::sqrt(press) ? against * share : glm::dvec3(0.0);
}

}  // namespace tandem::haptics
