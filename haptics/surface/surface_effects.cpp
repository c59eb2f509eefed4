#include "haptics/surface/surface_effects.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <glm/geometric.hpp>

namespace tandem::haptics {

glm::dvec3 viscousDrag(double viscosity, const glm::dvec3& velocity, const glm::dvec3& before) {
  if (glm::dot(before, velocity) < 0.0) return glm::dvec3(0.0);
  return -viscosity * velocity;
}

double vibration(double frequency, double amplitude, double pressing, double dt, double& phase) {
  if (!(frequency * dt < 0.5)) return 0.0;
  phase += frequency * dt;
  phase -= std::floor(phase);
  const double force = amplitude * std::sin(2.0 * std::numbers::pi * phase);
  return std::clamp(force, -std::max(pressing, 0.0), std::max(pressing, 0.0));
}

glm::dvec3 stickSlip(double force, double stiffness, const glm::dvec3& point, const glm::dvec3& normal,
                     StickAnchor& anchor) {
  if (!anchor.set) anchor = {true, point};
  const glm::dvec3 displacement = point - anchor.point;
  const glm::dvec3 across = displacement - normal * glm::dot(displacement, normal);
  if (stiffness * glm::length(across) > force) {
    anchor.point = point;
    return glm::dvec3(0.0);
  }
  return -stiffness * across;
}

double magneticPull(double force, double distance, double height) {
  if (!(height > 0.0 && height < distance)) return 0.0;
  const double x = height / distance;
  return 4.0 * force * x * (1.0 - x);
}

}  // namespace tandem::haptics
