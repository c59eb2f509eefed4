#pragma once

// Force effects of a touched surface, one function each. All arguments share one frame, world or part; N, m,
// s.

#include <glm/vec3.hpp>

namespace tandem::haptics {

/// Drag of a viscous surface: F = -c v, with v relative to the surface and `before` the v of the last tick.
/// Zero while the tool reverses from tick to tick (v . before < 0), because a force held for the tick would
/// then push along the motion.
glm::dvec3 viscousDrag(double viscosity, const glm::dvec3& velocity, const glm::dvec3& before);

/// Vibration of a touched surface along its normal: A sin(2 pi f t), with the phase (in turns) advanced by f
/// dt. It is limited to `pressing`, so that it cannot pull, and zero at f of half the tick rate and above,
/// which the loop cannot render.
double vibration(double frequency, double amplitude, double pressing, double dt, double& phase);

/// The point at which a stick-slip surface holds the tool.
struct StickAnchor {
  bool set = false;
  glm::dvec3 point{0.0, 0.0, 0.0};  // m, part frame
};

/// Tangential stick-slip spring to an anchor: F = -k t, with t the displacement from the anchor across the
/// normal. At |F| > `force` it slips and sticks again where the tool is; the stored energy is lost (Salisbury
/// et al. 1995).
glm::dvec3 stickSlip(double force, double stiffness, const glm::dvec3& point, const glm::dvec3& normal,
                     StickAnchor& anchor);

/// Pull of a magnetic surface at height s above it: 4 F x (1 - x), x = s / distance, and 0 outside of 0 < x <
/// 1. Continuous, at most F (at half the distance), and the derivative of a potential of s.
double magneticPull(double force, double distance, double height);

}  // namespace tandem::haptics
