#pragma once

// How heavy each site's replica of a part is. The masses of all replicas, and what the lines between them add, come to
// that of the part.

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

#include "assets/scene/scene.h"
#include "haptics/body/virtual_coupling.h"

namespace tandem::haptics {

/// That of each of `sites` replicas of a part, `lineMass` kg on a lever of `lever` m being taken off for the lines that
/// end here (half of what each adds); no less than a tenth of the share, nor kLeastReplicaMass where the share is more.
assets::MassProperties replicaMass(const assets::MassProperties& part, int sites, double lineMass,
                                   double lever);

inline constexpr double kLeastReplicaMass = 0.03;  // kg

/// Changes a body's mass towards `target` by at most `most` kg, its inertia in step. Never adds kinetic energy: what
/// gets lighter keeps its velocity, what gets heavier its momentum.
void changeMass(RigidBody& body, const assets::MassProperties& target, double most);

/// changeMass() over time. A hand that moves a part at v feels v dm/dt as it gets heavier, so the rate grows from zero.
class MassRamp {
 public:
  void advance(RigidBody& body, const assets::MassProperties& target, double dt);

 private:
  static constexpr double kGrowing = 1.0, kFalling = 3.0;  // kg/s, at most: what gets lighter is not felt
  static constexpr double kRise = 0.3;                     // s, to kGrowing
  double rate_ = 0.0;                                      // kg/s, signed
};

}  // namespace tandem::haptics
