#include "haptics/devices/simulated_arm.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

namespace tandem::haptics {
namespace {

constexpr double kVelocityFilterTime = 3.2e-3;  // s

HandTarget restingAt(const Pose& pose) {
  HandTarget target;
  target.worldFromTarget = pose;
  return target;
}

SimulatedDeviceParameters tipOf(const ImpedanceArmParameters& arm) {
  SimulatedDeviceParameters tip;
  tip.mass = arm.mass;
  tip.quantum = 0.0;  // the encoders', not the tip's
  // The links' weight comes on top of what the motors may push.
  tip.forceMax = 2.0 * arm.maxForce;
  return tip;
}

/// The base upright, so placed that the nominal tip is at a world position.
Pose baseUnder(const glm::dvec3& tip, const ImpedanceArm& arm) {
  return {tip - arm.tip({arm.parameters().nominal, {}}).position, glm::dquat(1.0, 0.0, 0.0, 0.0)};
}

/// Half the nominal reach to the side: the data sheet's workspace is 160 mm wide.
constexpr double kWorkspaceShare = 0.3;  // of the links' length

}  // namespace

SimulatedArm::SimulatedArm(const Pose& worldFromStart, const ImpedanceArmParameters& arm,
                           const ArmParameters& person)
    : HandDevice(worldFromStart, person, tipOf(arm), kWorkspaceShare * (arm.upperArm + arm.forearm)),
      arm_(arm),
      worldFromBase_(baseUnder(worldFromStart.position, arm_)),
      target_(restingAt(worldFromStart)) {
  joints_ = arm_.jointsFor(inverse(worldFromBase_) * worldFromStart);
  encoded_ = arm_.encoded(joints_);
  worldFromReading_ = worldFromBase_ * arm_.tip(encoded_);
}

DeviceLimits SimulatedArm::limits() const {
  DeviceLimits limits = HandDevice::limits();
  const ImpedanceArmParameters& p = arm_.parameters();
  limits.maxForce = p.maxForce;
  limits.quantum = 2.0 * std::numbers::pi / p.countsPerTurn * p.upperArm;
  return limits;
}

void SimulatedArm::setTarget(const HandTarget& target) {
  if (isValid(target)) target_.write(target);
}

HandTarget SimulatedArm::nextTarget(double) { return target_.latest(); }

glm::dvec3 SimulatedArm::actuated(const glm::dvec3& force, double dt) {
  const glm::dquat baseFromWorld = glm::conjugate(worldFromBase_.orientation);
  command_ = arm_.command(encoded_.arm, baseFromWorld * force, heat_, dt);
  // The motors' torques follow the encoded joints; the hand feels the force of those torques at the true
  // joints.
  const glm::dvec3 torque = command_.torque + arm_.gravityTorque(joints_.arm);
  command_.force = arm_.forceOf(joints_.arm, torque);
  return worldFromBase_.orientation * command_.force;
}

void SimulatedArm::afterStep(SimulatedHand& hand, double dt) {
  const Pose baseFromTip = inverse(worldFromBase_) * hand.devicePose();
  joints_ = arm_.jointsFor(baseFromTip);
  const glm::dvec3 reached = arm_.tip(joints_).position;
  // Apart from rounding the two differ only where a joint is at its stop.
  if (glm::length(reached - baseFromTip.position) > 1e-9 * arm_.parameters().upperArm)
    hand.stopAt(transformPoint(worldFromBase_, reached));

  encoded_ = arm_.encoded(joints_);
  const Pose last = worldFromReading_;
  worldFromReading_ = worldFromBase_ * arm_.tip(encoded_);
  const double fresh = 1.0 - std::exp(-dt / kVelocityFilterTime);
  const glm::dvec3 turn = rotationVector(worldFromReading_.orientation * glm::conjugate(last.orientation));
  readingTwist_.linear += fresh * ((worldFromReading_.position - last.position) / dt - readingTwist_.linear);
  readingTwist_.angular += fresh * (turn / dt - readingTwist_.angular);
}

DeviceSample SimulatedArm::reading(double now) const {
  DeviceSample sample;
  sample.worldFromDevice = worldFromReading_;
  sample.twist = readingTwist_;
  sample.time = now;
  sample.valid = tandem::isValid(worldFromReading_);
  return sample;
}

}  // namespace tandem::haptics
