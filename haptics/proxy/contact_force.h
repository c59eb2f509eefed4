#pragma once

// Contact force: turns the gap between proxy (god object) and device into the force of each contact on the
// hand.

#include <algorithm>
#include <array>

#include "haptics/base/tick_types.h"
#include "haptics/proxy/proxy.h"
#include "haptics/scene/contact_world.h"

namespace tandem::haptics {

/// Spring forces of up to three contacts, each along its own normal, N.
struct NormalForces {
  std::array<double, 3> along{};
};

/// Spring forces of up to three contacts, as the gradient of one potential. With independent unit normals
/// n_i, depths lambda_i >= 0 (m; x - g = sum lambda_i n_i, x the proxy and g the goal) and stiffnesses k_i
/// (N/m):
///     U(g) = 1/2 k |x - g|^2,   k = sum k_i lambda_i^2 / sum lambda_i^2,   F = -dU/dg = sum along_i n_i.
/// k is homogeneous of degree 0, and dk/dlambda_i = 0 at lambda_i = 0, so F is continuous where contacts
/// begin and end. A single contact gives k_1 lambda_1; equal stiffnesses give k (x - g). The force step
/// between two nearly coplanar faces is capped (kSteepest in the source).
NormalForces normalForces(const std::array<glm::dvec3, 3>& normals, const std::array<double, 3>& depths,
                          const std::array<double, 3>& stiffnesses, int count);

/// Force of the proxy's contacts on the hand before any limit, N, world axes. It consists of normalForces(),
/// the damping of each contact (normal speed only, never pulling), and the tangential lag held by friction
/// times the mean stiffness of the contacts. Appends the contacts to `out`.
glm::dvec3 contactForce(const ContactWorld& world, const Proxy& proxy, const DeviceSample& device,
                        const TickParameters& parameters, TickOutput& out);

/// Limits a stiffness that a material or surface states, N/m, to what the device can render stably.
inline double limitedStiffness(double stiffness, const TickParameters& parameters) {
  return parameters.stiffnessLimit > 0.0 ? std::min(stiffness, parameters.stiffnessLimit) : stiffness;
}

/// Limits a damping or viscosity that a surface states, N·s/m, to what the device can render stably.
inline double limitedDamping(double damping, const TickParameters& parameters) {
  return parameters.dampingLimit > 0.0 ? std::min(damping, parameters.dampingLimit) : damping;
}

/// Damping of a contact with this material, N·s/m; a material without damping takes the parameters' value.
inline double contactDamping(const assets::Material& material, const TickParameters& parameters) {
  return limitedDamping(material.damping > 0.0 ? material.damping : parameters.damping, parameters);
}

}  // namespace tandem::haptics
