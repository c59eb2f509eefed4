#pragma once

// Model of a person's arm and hand on an impedance device: two masses per translational axis (arm, device)
// joined by the grip, driven by the target that the person intends. Used by simulations and tests, and, with
// the mouse as the target, by the virtual stylus, which needs no hardware.
//
//   arm:     m_a a_a = k (x_target - x_a) + b (v_target - v_a) + m_a a_target - F_grip
//   grip:    F_grip = k_g (x_a - x_d) + b_g (v_a - v_d)      (zero once the person has let go of the stylus)
//   device:  m_d a_d = F_grip + F_command - b_d v_d - F_c tanh(v_d / 1 mm/s)
//
// The commanded force is held over a tick, the reading is quantised, and each tick is integrated in ten
// semi-implicit steps. Orientation follows the target with a first-order lag of 50 ms and ignores torque.
//
// A hand that has let go still follows its target. When it takes hold again the grip pulls the device towards
// it, so the caller first moves the target back to the device.

#include "assets/base/pose.h"
#include "haptics/base/device.h"

namespace tandem::haptics {

/// `force` shortened to a length of at most `limit`; zero for a non-finite force.
glm::dvec3 limited(const glm::dvec3& force, double limit);

/// A person's arm. Defaults: a relaxed adult arm.
struct ArmParameters {
  double mass = 1.46;            // kg
  double stiffness = 48.8;       // N/m
  double damping = 4.5;          // N·s/m
  double gripStiffness = 375.0;  // N/m
  double gripDamping = 7.9;      // N·s/m
};

/// A device of the class of a desktop haptic arm.
struct SimulatedDeviceParameters {
  double mass = 0.045;        // kg
  double damping = 0.1;       // N·s/m
  double friction = 0.05;     // N, Coulomb
  double quantum = 0.055e-3;  // m
  double forceMax = 3.3;      // N
};

/// The state that the person intends.
struct HandTarget {
  Pose worldFromTarget;
  glm::dvec3 velocity{0.0, 0.0, 0.0};      // m/s
  glm::dvec3 acceleration{0.0, 0.0, 0.0};  // m/s^2
  bool holdsStylus = true;
};

class SimulatedHand {
 public:
  SimulatedHand(const ArmParameters& arm, const SimulatedDeviceParameters& device,
                const Pose& worldFromStart);

  /// Advances by dt > 0 seconds (the model was fitted at 1 ms) under a target and a commanded force in N,
  /// clamped to forceMax; a non-finite force counts as zero.
  void step(const HandTarget& target, const glm::dvec3& commandedForce, double dt);

  /// Puts the device's tip where a mechanical stop holds it, m, and removes its speed: an inelastic stop,
  /// which only loses energy. The next step continues from there.
  void stopAt(const glm::dvec3& position);

  /// Reading of the device: quantised position, and velocity by a filtered difference of readings as in a
  /// driver.
  DeviceSample sample(double now) const;

  /// True device pose and velocity, m and m/s, for measurements without quantisation.
  const Pose& devicePose() const { return worldFromDevice_; }
  const glm::dvec3& deviceVelocity() const { return deviceVelocity_; }
  const Pose& armPose() const { return worldFromArm_; }

  /// Energy in J that the commanded force has given to the device so far: the integral of F.v, exact within
  /// the steps.
  double energyGiven() const { return energyGiven_; }

 private:
  ArmParameters arm_;
  SimulatedDeviceParameters device_;
  Pose worldFromArm_, worldFromDevice_;
  glm::dvec3 armVelocity_{0.0, 0.0, 0.0}, deviceVelocity_{0.0, 0.0, 0.0}, angularVelocity_{0.0, 0.0, 0.0};
  glm::dvec3 reading_{0.0, 0.0, 0.0}, readingVelocity_{0.0, 0.0, 0.0};
  double energyGiven_ = 0.0;
};

}  // namespace tandem::haptics
