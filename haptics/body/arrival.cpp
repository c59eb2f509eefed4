#include "haptics/body/arrival.h"

#include <algorithm>

#include <glm/geometric.hpp>

namespace tandem::haptics {

glm::dvec3 Arrival::heldBack(const glm::dvec3& force, double step) {
  const double held = glm::length(held_);
  if (!(held > 0.0)) return held_;
  const glm::dvec3 along = held_ / held;
  const double now = std::clamp(glm::dot(force, along), 0.0, held);
  held_ = along * std::max(0.0, now - step);
  return along * now;
}

}  // namespace tandem::haptics
