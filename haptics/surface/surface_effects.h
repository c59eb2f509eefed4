#pragma once

// Force effects of a touched surface, one function each. World or part axes as long as all arguments agree;
// N, m, s.

#include <glm/vec3.hpp>

namespace tandem::haptics {

/// Drag of a viscous surface: F = -c v, v relative to the surface, `before` that of the last tick. None while
/// the tool turns round from tick to tick (v . before < 0): the force is held for a tick, and would then push
/// along the motion.
glm::dvec3 viscousDrag(double viscosity, const glm::dvec3& velocity, const glm::dvec3& before);

/// Buzz of a touched surface along its normal: A sin(2 pi f t), phase in turns advanced by f dt; never more
/// than `pressing`, so that it cannot pull; 0 from half the tick rate on, where it could not be shown.
double vibration(double frequency, double amplitude, double pressing, double dt, double& phase);

/// Where a stick-slip surface holds the tool.
struct StickAnchor {
  bool set = false;
  glm::dvec3 point{0.0, 0.0, 0.0};  // m, part frame
};

/// Tangential spring to an anchor: F = -k t, t the way from the anchor across the normal. At |F| > `force` it
/// lets go and holds on anew where the tool is: what was stored is lost (Salisbury et al. 1995).
glm::dvec3 stickSlip(double force, double stiffness, const glm::dvec3& point, const glm::dvec3& normal,
                     StickAnchor& anchor);

/// Pull of a magnetic surface at height s above it: 4 F x (1 - x), x = s / distance, 0 outside of 0 < x < 1.
/// Continuous, at most F at half the distance, and the derivative of a potential of s.
double magneticPull(double force, double distance, double height);

}  // namespace tandem::haptics
