#pragma once

// Base of all devices with a simulated hand: poll() advances the hand by the elapsed time under the last
// applied force towards a target from the derived class.
//
// Threads: poll() and apply() from the servo thread; a derived class receives data from other threads by
// triple buffer.

#include <atomic>

#include "haptics/base/device.h"
#include "haptics/operator/simulated_hand.h"

namespace tandem::haptics {

/// Seconds without a force after which a device sends zero by itself.
inline constexpr double kForceWatchdog = 0.05;

/// Time to integrate for a poll at `now` after one at `last`: never negative, and at most 20 ms, so that the
/// hand does not leap after a long pause of the program.
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

  /// The hand itself, for measurements; servo thread, or any thread while no loop runs.
  const SimulatedHand& hand() const { return hand_; }

 protected:
  HandDevice(const Pose& worldFromStart, const ArmParameters& arm, const SimulatedDeviceParameters& device,
             double workspaceRadius);

  /// Runs once per poll, before the hand moves.
  virtual void beginPoll(double) {}
  /// The target for the next `dt` seconds; runs for each step.
  virtual HandTarget nextTarget(double dt) = 0;
  virtual std::uint32_t pressedButtons() const = 0;
  /// The force that the device's motors deliver for the requested one, N, over the next `dt` seconds.
  virtual glm::dvec3 actuated(const glm::dvec3& force, double) { return force; }
  /// Runs after each step of `dt` seconds: mechanical stops, sensor readings.
  virtual void afterStep(SimulatedHand&, double) {}
  /// The reading that poll() returns, without the buttons.
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
