#pragma once

// Surface effects of the touched parts on the contact force: force shading, relief, contact laws, drag,
// vibration, stick-slip, magnets, pop-through.
//
// For each contact with a surface, in the part's frame, with g the device position less the lag of friction:
//   d(g), n          depth under the curved patch and its normal (force_shading.h); the facet's if not shaded
//   D = d + r + h    r the tool's radius, h the relief (haptic_texture.h)
//   F = f(D) grad(-D) + the effects; f by the contact law (contact_law.h), k D where it is elastic
// For the elastic law F is the gradient of a potential of g, so no closed path gains energy.

#include <array>

#include "haptics/base/fixed_vector.h"
#include "haptics/base/tick_types.h"
#include "haptics/proxy/proxy.h"
#include "haptics/scene/contact_world.h"
#include "haptics/surface/contact_law.h"
#include "haptics/surface/shading_limit.h"
#include "haptics/surface/surface_effects.h"

namespace tandem::haptics {

inline constexpr int kMaxSurfaceContacts = 4;  // contacts that are remembered at once
inline constexpr int kMaxDents = 32;           // of plastic surfaces; the oldest makes room

/// Persistent state of one contact.
struct SurfaceSlot {
  PartId part = kNoPart;
  bool active = false;  // acted in the last tick
  ViscoelasticMemory law;
  double stiffness = 0.0, stiffness2 = 0.0, relaxation = 0.0;  // N/m, N/m, s: of the recovery
  StickAnchor anchor;
  double phase = 0.0;                  // turns, of the vibration
  glm::dvec3 velocity{0.0, 0.0, 0.0};  // m/s, of the tool relative to the surface
};

/// A permanent dent: `depth` (1 - (x / width)^2)^2 around `point`.
struct Dent {
  PartId part = kNoPart;
  glm::dvec3 point{0.0, 0.0, 0.0};  // m, part frame
  double depth = 0.0, width = 0.0;  // m
};

/// Persistent state of one hand's surface contacts.
struct SurfaceState {
  ShadingMemory shading;
  std::array<SurfaceSlot, kMaxSurfaceContacts> slots;
  FixedVector<Dent, kMaxDents> dents;
  PartId letGo = kNoPart;  // the part whose surface gave way in this tick
};

/// Adds all surface effects to `force`, which is contactForce()'s, and updates the contacts. `out` holds the
/// contacts of contactForce(), one per pressing plane, in order. For scenes with a SurfaceScene only.
glm::dvec3 applySurfaceEffects(const ContactWorld& world, const Proxy& proxy, const DeviceSample& device,
                               const TickParameters& parameters, const glm::dvec3& force, SurfaceState& state,
                               TickOutput& out);

/// applySurfaceEffects() for any scene; without surfaces it costs one comparison.
inline glm::dvec3 applySurface(const ContactWorld& world, const Proxy& proxy, const DeviceSample& device,
                               const TickParameters& parameters, const glm::dvec3& force, SurfaceState& state,
                               TickOutput& out) {
  if (world.surfaces() == nullptr) return force;
  return applySurfaceEffects(world, proxy, device, parameters, force, state, out);
}

}  // namespace tandem::haptics
