#pragma once

// A person's arm on a desktop device, aimed from outside: the hand of simulations and of scripted sites.
//
// Threads: setTarget() and setButtons() from any one thread; poll() and apply() from the servo thread.

#include "haptics/base/triple_buffer.h"
#include "haptics/operator/hand_device.h"

namespace tandem::haptics {

class SimulatedDevice : public HandDevice {
 public:
  explicit SimulatedDevice(const Pose& worldFromStart = {}, const ArmParameters& arm = {},
                           const SimulatedDeviceParameters& device = {});

  std::string name() const override { return "simulated"; }

  /// Sets what the person aims at from now on. A non-finite target is ignored.
  void setTarget(const HandTarget& target);
  void setButtons(std::uint32_t buttons) { buttons_.store(buttons, std::memory_order_relaxed); }

 private:
  HandTarget nextTarget(double dt) override;
  std::uint32_t pressedButtons() const override { return buttons_.load(std::memory_order_relaxed); }

  TripleBuffer<HandTarget> target_;
  std::atomic<std::uint32_t> buttons_{0};
};

}  // namespace tandem::haptics
