#pragma once

// From where the proxy is to the force of its contacts on the hand.

#include "haptics/contact_world.h"
#include "haptics/proxy.h"
#include "haptics/tick.h"

namespace tandem::haptics {

/// Force of the proxy's contacts on the hand, N, world axes, before any limit. Springs between proxy and
/// device: each plane with its own stiffness and damping along its normal, and what is left (friction) with
/// their mean. Damping sees the normal speed only and never pulls. Writes the contacts, of which those that
/// press have a force, to `out`.
glm::dvec3 contactForce(const ContactWorld& world, const Proxy& proxy, const DeviceSample& device,
                        const TickParameters& parameters, TickOutput& out);

}  // namespace tandem::haptics
