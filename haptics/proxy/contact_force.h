#pragma once

// From where the proxy is to the force of its contacts on the hand.

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

/// Springs of several stiffnesses as the gradient of one potential. With independent unit normals n_i and
/// depths lambda_i >= 0 (m; x - g = sum lambda_i n_i) and stiffnesses k_i (N/m):
///     U(g) = 1/2 k |x - g|^2,   k = sum k_i lambda_i^2 / sum lambda_i^2,   F = -dU/dg = sum along_i n_i.
/// k is homogeneous of degree 0 and does not change to first order as a contact begins (dk/dlambda_i = 0 at
/// lambda_i = 0): F is continuous where contacts come and go. One contact: k_1 lambda_1; equal stiffnesses:
/// k (x - g). The step between two faces that are nearly one plane is capped (kSteepest in the source).
NormalForces normalForces(const std::array<glm::dvec3, 3>& normals, const std::array<double, 3>& depths,
                          const std::array<double, 3>& stiffnesses, int count);

/// Force of the proxy's contacts on the hand, N, world axes, before any limit: normalForces() less the
/// damping of each contact (normal speed only, never pulling), and what lag is left (friction) with their
/// mean stiffness. Writes the contacts to `out`.
glm::dvec3 contactForce(const ContactWorld& world, const Proxy& proxy, const DeviceSample& device,
                        const TickParameters& parameters, TickOutput& out);

/// A damping or viscosity that a surface states, N·s/m, as the device bears it.
inline double limitedDamping(double damping, const TickParameters& parameters) {
  return parameters.dampingLimit > 0.0 ? std::min(damping, parameters.dampingLimit) : damping;
}

/// Damping of a contact with this material, N·s/m: the parameters' where it states none.
inline double contactDamping(const assets::Material& material, const TickParameters& parameters) {
  return limitedDamping(material.damping > 0.0 ? material.damping : parameters.damping, parameters);
}

}  // namespace tandem::haptics
