#pragma once

// What every device with a simulated hand has in common: the hand is advanced inside poll() by the time that
// has passed, under the force last applied, towards a target that the derived class names.
//
// Threads: poll() and apply() from the servo thread; what a derived class takes from elsewhere comes by
// triple buffer.

#include <atomic>

#include "haptics/base/device.h"
#include "haptics/operator/simulated_hand.h"

namespace tandem::haptics {

/// Seconds after which a device that has heard no force sends zero by itself.
inline constexpr double kForceWatchdog = 0.05;

/// The time to integrate for a poll at `now` after one at `last`: never negative, and a program that stood
/// still for long does not make its hand leap (at most 20 ms).
double pollInterval(double last, double now);

/// Whether every number of a target is finite and its orientation is a unit quaternion.
bool isValid(const HandTarget& target);

class HandDevice : public Device {
 public:
  DeviceLimits limits() const override;
  Status open() override;
  void close() override {}
  DeviceSample poll(double now) override;
  void apply(const Wrench& toHand) override;

  /// The hand itself, for measures; servo thread, or any thread while no loop runs.
  const SimulatedHand& hand() const { return hand_; }

 protected:
  HandDevice(const Pose& worldFromStart, const ArmParameters& arm, const SimulatedDeviceParameters& device,
             double workspaceRadius);

  /// Called once a poll, before the hand moves.
  virtual void beginPoll(double) {}
  /// The target for the next `dt` seconds; called for each step.
  virtual HandTarget nextTarget(double dt) = 0;
  virtual std::uint32_t pressedButtons() const = 0;
  /// What the device's motors make of the force that was asked for, N, for the next `dt` seconds.
  virtual glm::dvec3 actuated(const glm::dvec3& force, double) { return force; }
  /// Called after each step of `dt` seconds: mechanical stops, readings of one's own.
  virtual void afterStep(SimulatedHand&, double) {}
  /// The reading that poll() hands out, without the buttons.
  virtual DeviceSample reading(double now) const { return hand_.sample(now); }

 private:
  SimulatedDeviceParameters parameters_;
  double workspaceRadius_;
  SimulatedHand hand_;
  glm::dvec3 force_{0.0, 0.0, 0.0};
  double lastPoll_ = 0.0, lastApply_ = 0.0;
  bool started_ = false;
};

}  // namespace tandem::haptics
