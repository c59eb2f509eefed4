#pragma once

// A person's arm on an impedance device with joints: the hand model (simulated_hand.h) holds the tip of an
// ImpedanceArm.
//
// 1. A force passes through J^T, the motors' currents and their limits, and J^-T, at the encoded joints;
//    where the arm cannot deliver it, the hand feels less.
// 2. A reading is the tip of the encoded joints, so its resolution is that of the encoders and varies over
//    the workspace.
// 3. At the end of a joint's range the tip stops inelastically.
//
// Threads: setTarget() and setButtons() from any one thread; poll() and apply() from the servo thread.

#include "haptics/base/triple_buffer.h"
#include "haptics/operator/hand_device.h"
#include "haptics/operator/impedance_arm.h"

namespace tandem::haptics {

class SimulatedArm : public HandDevice {
 public:
  /// The tip begins at `worldFromStart`, in the arm's nominal pose; the base stands upright.
  explicit SimulatedArm(const Pose& worldFromStart = {}, const ImpedanceArmParameters& arm = {},
                        const ArmParameters& person = {});

  std::string name() const override { return "simulated-arm"; }
  DeviceLimits limits() const override;

  /// Sets what the person aims at from now on. A non-finite target is ignored.
  void setTarget(const HandTarget& target);
  void setButtons(std::uint32_t buttons) { buttons_.store(buttons, std::memory_order_relaxed); }

  /// For measurements; servo thread, or any thread while no loop runs.
  const ImpedanceArm& arm() const { return arm_; }
  const ArmJoints& joints() const { return joints_; }
  const ArmCommand& command() const { return command_; }
  const Pose& worldFromBase() const { return worldFromBase_; }

 private:
  HandTarget nextTarget(double dt) override;
  std::uint32_t pressedButtons() const override { return buttons_.load(std::memory_order_relaxed); }
  glm::dvec3 actuated(const glm::dvec3& force, double dt) override;
  void afterStep(SimulatedHand& hand, double dt) override;
  DeviceSample reading(double now) const override;

  ImpedanceArm arm_;
  Pose worldFromBase_;
  ArmJoints joints_, encoded_;
  ArmCommand command_;
  glm::dvec3 heat_{0.0, 0.0, 0.0};  // A^2
  Pose worldFromReading_;
  Twist readingTwist_;
  TripleBuffer<HandTarget> target_;
  std::atomic<std::uint32_t> buttons_{0};
};

}  // namespace tandem::haptics
