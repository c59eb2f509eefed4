#include "haptics/operator/steered_hand.h"

#include <cmath>
#include <glm/geometric.hpp>

namespace tandem::haptics {
namespace {

constexpr double kSmoothing = 0.02;  // s: reports come every 4 to 16 ms

/// Steadier and better damped than a relaxed arm, as for the mouse, because no real arm's mass steadies it.
constexpr ArmParameters kArm{
    .mass = 0.5, .stiffness = 300.0, .damping = 20.0, .gripStiffness = 800.0, .gripDamping = 10.0};

}  // namespace

SteeredHand::SteeredHand(const Pose& worldFromStart)
    : HandDevice(worldFromStart, kArm, {}, 0.2), target_(worldFromStart) {}

DeviceLimits SteeredHand::limits() const {
  DeviceLimits limits = HandDevice::limits();
  limits.actuatedAxes = 0;
  return limits;
}

void SteeredHand::setView(const SteeringView& view) {
  if (isValid(Pose{{view.maxSpeed, 0.0, 0.0}, view.worldFromView})) view_.write(view);
}

HandTarget SteeredHand::nextTarget(double dt) {
  const double share = 1.0 - std::exp(-dt / kSmoothing);
  const glm::dvec3 change = share * (wanted_.linear - twist_.linear);
  twist_.linear += change;
  twist_.angular += share * (wanted_.angular - twist_.angular);
  target_ = integrate(target_, twist_, dt);

  // A hand held back by a surface pulls its target along: a deflection is a push of bounded force and does
  // not wind up.
  const glm::dvec3 here = hand().devicePose().position;
  const glm::dvec3 ahead = target_.position - here;
  const double reach = HandDevice::limits().maxForce / kArm.stiffness;
  if (glm::length(ahead) <= reach) return {target_, twist_.linear, change / dt, true};
  target_.position = here + limited(ahead, reach);
  return {target_, {0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}, true};
}

}  // namespace tandem::haptics
