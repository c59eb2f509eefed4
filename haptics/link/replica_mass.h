#pragma once

// Mass of each site's replica of a part. The masses of all replicas and of the links between them sum to the
// mass of the part.

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

#include "assets/scene/scene.h"
#include "haptics/body/virtual_coupling.h"

namespace tandem::haptics {

/// Mass properties of each of `sites` replicas of a part, less `linkMass` kg on a lever of `lever` m for the
/// links that end here (half of what each adds). At least a tenth of the share remains, and at least
/// kMinReplicaMass where the share is more.
assets::MassProperties replicaMass(const assets::MassProperties& part, int sites, double linkMass,
                                   double lever);

inline constexpr double kMinReplicaMass = 0.03;  // kg

/// Changes a body's mass towards `target` by at most `limit` kg, and its inertia by the same share. Never
/// adds kinetic energy: a body that gets lighter keeps its velocity, one that gets heavier its momentum.
void changeMass(RigidBody& body, const assets::MassProperties& target, double limit);

/// changeMass() over time. A hand that moves a part at v feels v dm/dt as the part gets heavier, so the rate
/// grows from zero.
class MassRamp {
 public:
  void advance(RigidBody& body, const assets::MassProperties& target, double dt);

 private:
  static constexpr double kGrowing = 1.0, kFalling = 3.0;  // kg/s, limits; a loss of mass is not felt
  static constexpr double kRise = 0.3;                     // s, until the rate is kGrowing
  double rate_ = 0.0;                                      // kg/s, signed
};

}  // namespace tandem::haptics
