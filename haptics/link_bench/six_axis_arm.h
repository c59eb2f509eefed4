#pragma once

// A person's arm on a device in six axes; simulated_hand.h is the same model in three.

#include "haptics/base/six_axes.h"
#include "haptics/operator/simulated_hand.h"

namespace tandem::bench {

inline constexpr double kTick = 1e-3;  // s

/// A firm arm; ArmParameters{} is the relaxed one. Fitted in laboratory experiments on one axis.
inline haptics::ArmParameters firmArm() { return {1.5, 300.0, 12.0, 800.0, 10.0}; }
inline haptics::ArmParameters relaxedArm() { return {}; }
/// An arm that holds on but is easily led.
inline haptics::ArmParameters lightArm() { return {1.46, 4.88, 4.5, 375.0, 7.9}; }

/// SimulatedHand's two masses in six axes. kLever converts angles to lengths for the hand, the grip and the
/// device alike.
class SixAxisArm {
 public:
  static constexpr double kLever = 0.07;  // m: the wrist of a firm arm holds 1.5 N·m/rad

  SixAxisArm(const haptics::ArmParameters& arm, const Pose& start);
  /// Advances a tick under a held command. The target is the start pose displaced by `displacement`.
  void step(const haptics::SixAxes& displacement, const haptics::SixAxes& velocity,
            const haptics::SixAxes& acceleration, const Wrench& command);
  void letGo() { held_ = false; }

  const Pose& reading() const { return read_; }
  Twist readingVelocity() const;
  const Pose& device() const { return device_; }
  double given() const { return given_; }  // J, from the command to the device

 private:
  void read();

  haptics::ArmParameters arm_;
  haptics::SimulatedDeviceParameters p_;
  Pose start_, armPose_, device_, read_;
  haptics::SixAxes armVelocity_, velocity_, readVelocity_;
  bool held_ = true;
  double given_ = 0.0;
};

/// The wrench that a device delivers of a requested one.
Wrench withinLimits(const Wrench& onHand);

}  // namespace tandem::bench
