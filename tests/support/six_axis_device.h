#pragma once

// A haptic device that drives six axes, as a model: a mass and an inertia with viscous damping in all axes, a
// wrench that is held over a period, a reading that may be quantised. Pushed by whatever wrench the hand
// gives.

#include <cmath>

#include <glm/geometric.hpp>

#include "haptics/base/device.h"

namespace tandem::test {

struct SixAxisParameters {
  double mass = 0.045;       // kg
  double inertia = 5e-5;     // kg m^2, about the tip, the same about all axes
  double damping = 1.0;      // N·s/m
  double rotDamping = 2e-3;  // N·m·s/rad
  double quantum = 0.0;      // m, of the position reading; 0 = exact
  double rotQuantum = 0.0;   // rad, of the rotation vector read

  haptics::DeviceLimits limits() const {
    haptics::DeviceLimits l;
    l.sensedAxes = l.actuatedAxes = 6;
    l.maxForce = 10.0;
    l.maxTorque = 0.5;
    l.mass = mass;
    l.inertia = inertia;
    l.damping = damping;
    l.rotDamping = rotDamping;
    l.quantum = quantum;
    return l;
  }
};

class SixAxisDevice {
 public:
  SixAxisDevice(const SixAxisParameters& parameters, const Pose& start)
      : p_(parameters), pose_(start), start_(start), read_(start) {}

  /// Advances by `period` s under the held command and the hand's own wrench. The midpoint rule in both ways
  /// of a step: force times way is then exactly what is stored and lost, so that the account is the
  /// sampling's alone.
  void step(const Wrench& command, const Wrench& hand, double period) {
    constexpr int kSteps = 20;
    const double h = period / kSteps;
    for (int i = 0; i < kSteps; ++i) {
      const glm::dvec3 v = midway(twist_.linear, command.force + hand.force, p_.mass, p_.damping, h);
      const glm::dvec3 w = midway(twist_.angular, command.torque + hand.torque, p_.inertia, p_.rotDamping, h);
      pose_.position += h * v;
      pose_.orientation = glm::normalize(fromRotationVector(h * w) * pose_.orientation);
      const double lost = p_.damping * glm::dot(v, v) + p_.rotDamping * glm::dot(w, w);
      given_ += h * (glm::dot(command.force, v) + glm::dot(command.torque, w) - lost);
    }
    mostGiven_ = std::max(mostGiven_, given_);
  }

  /// The reading, its velocity the difference to the one before.
  haptics::DeviceSample sample(double now, double period) {
    haptics::DeviceSample sample;
    sample.worldFromDevice = pose_;
    if (p_.quantum > 0.0) {
      for (int i = 0; i < 3; ++i)
        sample.worldFromDevice.position[i] = p_.quantum * std::floor(pose_.position[i] / p_.quantum + 0.5);
    }
    if (p_.rotQuantum > 0.0) {
      glm::dvec3 turn = rotationVector(pose_.orientation * glm::conjugate(start_.orientation));
      for (int i = 0; i < 3; ++i) turn[i] = p_.rotQuantum * std::floor(turn[i] / p_.rotQuantum + 0.5);
      sample.worldFromDevice.orientation = fromRotationVector(turn) * start_.orientation;
    }
    const Pose& reading = sample.worldFromDevice;
    sample.twist.linear = (reading.position - read_.position) / period;
    sample.twist.angular = rotationVector(reading.orientation * glm::conjugate(read_.orientation)) / period;
    read_ = reading;
    sample.time = now;
    sample.valid = true;
    return sample;
  }

  const Pose& pose() const { return pose_; }
  void setTwist(const Twist& twist) { twist_ = twist; }
  /// What command and damping together have given out, J: below zero for ever where the coupling is passive
  /// on this device, whatever the hand does. The most of it so far, at least 0.
  double given() const { return given_; }
  double mostGiven() const { return mostGiven_; }

 private:
  /// The mean velocity of a step; `velocity` goes on to its end.
  static glm::dvec3 midway(glm::dvec3& velocity, const glm::dvec3& force, double mass, double damping,
                           double h) {
    const glm::dvec3 before = velocity;
    const double share = 0.5 * h * damping / mass;
    velocity = ((1.0 - share) * velocity + h / mass * force) / (1.0 + share);
    return 0.5 * (before + velocity);
  }

  SixAxisParameters p_;
  Pose pose_, start_, read_;
  Twist twist_;
  double given_ = 0.0, mostGiven_ = 0.0;
};

}  // namespace tandem::test
