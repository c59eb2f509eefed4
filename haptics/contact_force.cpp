#include "haptics/contact_force.h"

#include <algorithm>

#include <glm/geometric.hpp>

namespace tandem::haptics {

glm::dvec3 contactForce(const ContactWorld& world, const Proxy& proxy, const DeviceSample& device,
                        const TickParameters& parameters, TickOutput& out) {
  glm::dvec3 force(0.0);
  glm::dvec3 rest = proxy.position - device.worldFromDevice.position;
  double depths = 0.0, stiffnesses = 0.0;
  for (int i = 0; i < proxy.planeCount; ++i) {
    const ProxyPlane& plane = proxy.planes[static_cast<std::size_t>(i)];
    if (!presses(plane)) continue;
    const SurfacePoint& surface = plane.surface;
    const assets::Material& material = world.material(surface.part, surface.triangle);
    const double stiffness = material.stiffness > 0.0 ? material.stiffness : parameters.stiffness;
    const double damping = material.damping > 0.0 ? material.damping : parameters.damping;
    const glm::dvec3 surfaceVelocity =
        velocityAt(world.pose(surface.part), world.twist(surface.part), surface.point);
    const double leaving = glm::dot(device.twist.linear - surfaceVelocity, surface.normal);
    const double along = std::max(0.0, stiffness * plane.multiplier - damping * leaving);
    force += along * surface.normal;
    rest -= plane.multiplier * surface.normal;
    depths += plane.multiplier;
    stiffnesses += plane.multiplier * stiffness;
    if (out.contactCount < kMaxContacts) {
      out.contacts[static_cast<std::size_t>(out.contactCount++)] = {surface.part, surface.point,
                                                                    surface.normal, along};
    }
  }
  if (depths > 0.0) force += rest * (stiffnesses / depths);
  return force;
}

}  // namespace tandem::haptics
