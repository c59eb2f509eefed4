#include "haptics/link_bench/held_block.h"

#include <algorithm>

#include <glm/geometric.hpp>

#include "haptics/link_bench/six_axis_arm.h"

namespace tandem::bench {
namespace {

constexpr double kWallStiffness = 5000.0, kWallDamping = 20.0;  // of all four corners together

}  // namespace

assets::MassProperties Block::massProperties() const {
  const glm::dvec3 s = size * size;
  glm::dmat3 inertia(0.0);
  inertia[0][0] = mass / 12.0 * (s.y + s.z);
  inertia[1][1] = mass / 12.0 * (s.x + s.z);
  inertia[2][2] = mass / 12.0 * (s.x + s.y);
  return {mass, glm::dvec3(0.0), inertia};
}

haptics::RigidBody bodyOf(const Block& block) {
  haptics::RigidBody body;
  const assets::MassProperties whole = block.massProperties();
  body.mass = whole.mass;
  body.inertia = whole.inertia;
  body.centreOfMass = kCentreOfMass;
  body.worldFromBody.position = -kCentreOfMass;
  return body;
}

Pose centreOf(const haptics::RigidBody& body) {
  return {transformPoint(body.worldFromBody, body.centreOfMass), body.worldFromBody.orientation};
}

Twist twistOfCentre(const haptics::RigidBody& body) {
  return {velocityAt(body.worldFromBody, body.twist, centreOf(body).position), body.twist.angular};
}

WallTouch touchWall(const Block& block, const haptics::RigidBody& body) {
  WallTouch touch;
  if (!block.wall) return touch;
  const Pose centre = centreOf(body);
  for (int corner = 0; corner < 4; ++corner) {
    const glm::dvec3 at =
        0.5 * block.size * glm::dvec3{1.0, corner & 1 ? 1.0 : -1.0, corner & 2 ? 1.0 : -1.0};
    const glm::dvec3 point = transformPoint(centre, at);
    const double depth = point.x - *block.wall;
    if (depth <= 0.0) continue;
    const double speed = velocityAt(body.worldFromBody, body.twist, point).x;
    const double push = std::max(0.0, 0.25 * (kWallStiffness * depth + kWallDamping * speed));
    const glm::dvec3 force{-push, 0.0, 0.0};
    touch.onBody.force += force;
    touch.onBody.torque += glm::cross(point - centre.position, force);
    touch.push += push;
  }
  return touch;
}

Twist stepHeld(haptics::RigidBody& body, std::span<const haptics::Coupling> grips,
               const haptics::LinkPull& load, std::span<Wrench> onHands) {
  const Pose bodyFromCentre{body.centreOfMass, {1.0, 0.0, 0.0, 0.0}};
  std::array<haptics::Coupling, haptics::kMaxCouplings> couplings;
  couplings[0] = {
      bodyFromCentre, body.worldFromBody * bodyFromCentre, {}, {0.0, load.damping, 0.0, load.rotDamping}};
  std::copy(grips.begin(), grips.end(), couplings.begin() + 1);
  haptics::CoupledStep step =
      haptics::coupleBody(body, {couplings.data(), 1 + grips.size()}, load.held, {}, kTick);
  Wrench rest = load.held;
  std::size_t count = 1;  // couplings below their limit
  for (std::size_t i = 0; i < grips.size(); ++i) {
    const haptics::CouplingForce& grip = step.couplings[1 + i];
    const Wrench wanted = grip.onHand(step.freeVelocity, step.freeSpin);
    onHands[i] = withinLimits(wanted);
    if (onHands[i].force == wanted.force && onHands[i].torque == wanted.torque) {
      couplings[count++] = grips[i];
      continue;
    }
    // The part receives no more than the device can deliver.
    rest.force -= onHands[i].force;
    rest.torque -= onHands[i].torque + glm::cross(grip.arm, onHands[i].force);
  }
  if (count <= grips.size()) step = haptics::coupleBody(body, {couplings.data(), count}, rest, {}, kTick);
  haptics::moveBody(body, step.freeVelocity, step.freeSpin, kTick);
  return {step.freeVelocity, step.freeSpin};
}

}  // namespace tandem::bench
