#pragma once

// A Device that is a SimulatedHand: advanced inside poll() by the time that has passed, under the last
// applied force.
//
// Threads: setTarget(), setButtons() from any one thread; poll() and apply() from the servo thread.

#include <atomic>

#include "haptics/device.h"
#include "haptics/simulated_hand.h"
#include "haptics/triple_buffer.h"

namespace tandem::haptics {

class SimulatedDevice : public Device {
 public:
  explicit SimulatedDevice(const Pose& worldFromStart = {}, const ArmParameters& arm = {},
                           const SimulatedDeviceParameters& device = {});

  std::string name() const override { return "simulated"; }
  DeviceLimits limits() const override;
  Status open() override;
  void close() override {}
  DeviceSample poll(double now) override;
  void apply(const Wrench& toHand) override;

  /// What the person aims at from now on. A target that is not finite is ignored.
  void setTarget(const HandTarget& target);
  void setButtons(std::uint32_t buttons) { buttons_.store(buttons, std::memory_order_relaxed); }

  /// The hand itself, for measures; servo thread, or any thread while no loop runs.
  const SimulatedHand& hand() const { return hand_; }

 private:
  SimulatedDeviceParameters parameters_;
  SimulatedHand hand_;
  TripleBuffer<HandTarget> target_;
  std::atomic<std::uint32_t> buttons_{0};
  glm::dvec3 force_{0.0, 0.0, 0.0};
  double lastPoll_ = 0.0, lastApply_ = 0.0;
  bool started_ = false;
};

/// Whether every number of a target is finite and its orientation is a unit quaternion.
bool isValid(const HandTarget& target);

/// Seconds after which a device that has heard no force sends zero by itself.
inline constexpr double kForceWatchdog = 0.05;

/// The time to integrate for a poll at `now` after one at `last`: never negative, and a program that stood
/// still for long does not make its hand leap (at most 20 ms).
double pollInterval(double last, double now);

}  // namespace tandem::haptics
