#include "haptics/operator/simulated_hand.h"

#include <cmath>
#include <glm/geometric.hpp>

#include "assets/base/assert.h"

namespace tandem::haptics {
namespace {

constexpr int kStepsPerTick = 10;
constexpr double kFrictionSpeed = 1e-3;            // m/s: below it Coulomb friction turns viscous
constexpr double kOrientationLag = 0.05;           // s
constexpr double kVelocityFilterTime = 3.1775e-3;  // s: weight 0.27 on the newest difference at 1 kHz

/// To the nearest multiple of `quantum` on each axis; unchanged when the quantum is zero.
glm::dvec3 quantised(const glm::dvec3& position, double quantum) {
  if (quantum <= 0.0) return position;
  const auto round = [quantum](double x) { return quantum * std::floor(x / quantum + 0.5); };
  return {round(position.x), round(position.y), round(position.z)};
}

glm::dvec3 coulomb(const glm::dvec3& velocity, double friction) {
  if (friction == 0.0) return glm::dvec3{0.0, 0.0, 0.0};
  const auto axis = [friction](double v) { return friction * std::tanh(v / kFrictionSpeed); };
  return {axis(velocity.x), axis(velocity.y), axis(velocity.z)};
}

}  // namespace

glm::dvec3 limited(const glm::dvec3& force, double limit) {
  const double magnitude = glm::length(force);
  if (!std::isfinite(magnitude)) return glm::dvec3{0.0, 0.0, 0.0};
  return magnitude > limit ? force * (limit / magnitude) : force;
}

SimulatedHand::SimulatedHand(const ArmParameters& arm, const SimulatedDeviceParameters& device,
                             const Pose& worldFromStart)
    : arm_(arm), device_(device), worldFromArm_(worldFromStart), worldFromDevice_(worldFromStart) {
  ASSERT(arm.mass > 0.0 && device.mass > 0.0 && isValid(worldFromStart));
  reading_ = quantised(worldFromStart.position, device.quantum);
}

void SimulatedHand::step(const HandTarget& target, const glm::dvec3& commandedForce, double dt) {
  ASSERT(dt > 0.0);
  const glm::dvec3 command = limited(commandedForce, device_.forceMax);
  const double h = dt / kStepsPerTick;
  glm::dvec3& armPosition = worldFromArm_.position;
  glm::dvec3& devicePosition = worldFromDevice_.position;
  for (int i = 0; i < kStepsPerTick; ++i) {
    glm::dvec3 grip{0.0, 0.0, 0.0};
    if (target.holdsStylus)
      grip = arm_.gripStiffness * (armPosition - devicePosition) +
             arm_.gripDamping * (armVelocity_ - deviceVelocity_);
    const glm::dvec3 onDevice =
        grip + command - device_.damping * deviceVelocity_ - coulomb(deviceVelocity_, device_.friction);
    const glm::dvec3 onArm = arm_.stiffness * (target.worldFromTarget.position - armPosition) +
                             arm_.damping * (target.velocity - armVelocity_) +
                             arm_.mass * target.acceleration - grip;
    deviceVelocity_ += onDevice * (h / device_.mass);
    armVelocity_ += onArm * (h / arm_.mass);
    devicePosition += h * deviceVelocity_;
    armPosition += h * armVelocity_;
    energyGiven_ += glm::dot(command, deviceVelocity_) * h;
  }

  const glm::dvec3 rotation =
      rotationVector(target.worldFromTarget.orientation * glm::conjugate(worldFromDevice_.orientation)) *
      (1.0 - std::exp(-dt / kOrientationLag));
  worldFromDevice_.orientation = glm::normalize(fromRotationVector(rotation) * worldFromDevice_.orientation);
  worldFromArm_.orientation = worldFromDevice_.orientation;
  angularVelocity_ = rotation / dt;

  const glm::dvec3 last = reading_;
  reading_ = quantised(devicePosition, device_.quantum);
  const double keep = std::exp(-dt / kVelocityFilterTime);
  readingVelocity_ = keep * readingVelocity_ + (1.0 - keep) / dt * (reading_ - last);
}

void SimulatedHand::stopAt(const glm::dvec3& position) {
  const glm::dvec3 back = position - worldFromDevice_.position;
  worldFromDevice_.position = position;
  const double square = glm::dot(back, back);
  if (square == 0.0) return;
  const double outwards = glm::dot(deviceVelocity_, back);
  if (outwards < 0.0) deviceVelocity_ -= back * (outwards / square);
}

DeviceSample SimulatedHand::sample(double now) const {
  DeviceSample sample;
  sample.worldFromDevice = {reading_, worldFromDevice_.orientation};
  sample.twist = {readingVelocity_, angularVelocity_};
  sample.time = now;
  sample.valid = isValid(sample.worldFromDevice);
  return sample;
}

}  // namespace tandem::haptics
