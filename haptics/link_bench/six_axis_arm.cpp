#include "haptics/link_bench/six_axis_arm.h"

#include <cmath>

namespace tandem::bench {
namespace {

using haptics::SixAxes;

constexpr int kSubsteps = 10;
constexpr double kFrictionSpeed = 1e-3;  // m/s

SixAxes coulomb(const SixAxes& v, double friction) {
  const auto axis = [friction](double x) {  // a smooth sign
    const double s = x / kFrictionSpeed;
    return friction * s / std::sqrt(1.0 + s * s);
  };
  return {{axis(v.along.x), axis(v.along.y), axis(v.along.z)},
          {axis(v.about.x), axis(v.about.y), axis(v.about.z)}};
}

glm::dvec3 quantised(const glm::dvec3& x, double quantum) {
  return {quantum * std::floor(x.x / quantum + 0.5), quantum * std::floor(x.y / quantum + 0.5),
          quantum * std::floor(x.z / quantum + 0.5)};
}

}  // namespace

Wrench withinLimits(const Wrench& onHand) {
  const double limit = haptics::SimulatedDeviceParameters{}.forceMax;
  return {haptics::limited(onHand.force, limit), haptics::limited(onHand.torque, limit * SixAxisArm::kLever)};
}

SixAxisArm::SixAxisArm(const haptics::ArmParameters& arm, const Pose& start)
    : arm_(arm), start_(start), armPose_(start), device_(start), read_(start) {}

Twist SixAxisArm::readingVelocity() const { return {readVelocity_.along, readVelocity_.about / kLever}; }

void SixAxisArm::step(const SixAxes& displacement, const SixAxes& velocity, const SixAxes& acceleration,
                      const Wrench& command) {
  const double h = kTick / kSubsteps;
  const SixAxes given{command.force, command.torque / kLever};
  const Pose target = haptics::applied(start_, displacement, kLever);
  for (int i = 0; i < kSubsteps; ++i) {
    SixAxes grip, drive = -50.0 * armVelocity_;
    if (held_) {
      grip = arm_.gripStiffness * haptics::displacementBetween(device_, armPose_, kLever) +
             arm_.gripDamping * (armVelocity_ - velocity_);
      drive = arm_.stiffness * haptics::displacementBetween(armPose_, target, kLever) +
              arm_.damping * (velocity - armVelocity_) + arm_.mass * acceleration;
    }
    velocity_ += (h / p_.mass) * (grip + given - p_.damping * velocity_ - coulomb(velocity_, p_.friction));
    armVelocity_ += (h / arm_.mass) * (drive - grip);
    device_ = haptics::applied(device_, h * velocity_, kLever);
    armPose_ = haptics::applied(armPose_, h * armVelocity_, kLever);
    given_ += h * haptics::dot(given, velocity_);
  }
  read();
}

void SixAxisArm::read() {
  const SixAxes displacement = haptics::displacementBetween(start_, device_, kLever);
  const SixAxes steps{quantised(displacement.along, p_.quantum), quantised(displacement.about, p_.quantum)};
  const Pose last = read_;
  read_ = haptics::applied(start_, steps, kLever);
  readVelocity_ = 0.73 * readVelocity_ + (0.27 / kTick) * haptics::displacementBetween(last, read_, kLever);
}

}  // namespace tandem::bench
