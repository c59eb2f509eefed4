#pragma once

// A block that people hold by grips, and a wall that stops its corners.

#include <array>
#include <optional>
#include <span>

#include "assets/scene/scene.h"
#include "haptics/body/virtual_coupling.h"
#include "haptics/link/coordination_link.h"

namespace tandem::bench {

struct Block {
  double mass = 1.0;                  // kg
  glm::dvec3 size{0.12, 0.08, 0.06};  // m
  std::optional<double> wall;         // m: the corners cannot pass it along x

  assets::MassProperties massProperties() const;  // about its centre of mass
};

inline constexpr glm::dvec3 kCentreOfMass{0.01, -0.02, 0.015};  // m, body frame, deliberately off the origin
/// Gains of a hand on a part.
inline constexpr haptics::CouplingGains kGrasp{1000.0, 2.0, 2.5, 5e-3};

/// A body of this block at rest with its centre of mass in the world's origin.
haptics::RigidBody bodyOf(const Block& block);
/// The body's centre of mass with its orientation.
Pose centreOf(const haptics::RigidBody& body);
Twist twistOfCentre(const haptics::RigidBody& body);

struct WallTouch {
  Wrench onBody;      // about the centre of mass
  double push = 0.0;  // N
};
/// Penalty force at the four corners that face the wall.
WallTouch touchWall(const Block& block, const haptics::RigidBody& body);

/// Steps a body, held by at most three grips and loaded by `load`, by a tick. Each hand feels at most what
/// its device can deliver, and the part receives no more. Returns the twist of its centre of mass.
Twist stepHeld(haptics::RigidBody& body, std::span<const haptics::Coupling> grips,
               const haptics::LinkPull& load, std::span<Wrench> onHands);

}  // namespace tandem::bench
