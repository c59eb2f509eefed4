#pragma once

// Stylus moved by mouse and keyboard: a simulated hand on a simulated desktop arm, without hardware.
//
// The mouse reports at 60 Hz. Its target passes a critically damped filter, so that the position, velocity
// and acceleration that reach the hand have no steps at 1 kHz. The hand then responds to the applied force
// like a person's: pressed against a wall, it stops there.
//
// Threads: setTarget() and setButtons() from one thread (the window's); poll() and apply() from the servo
// thread.

#include "haptics/base/triple_buffer.h"
#include "haptics/operator/hand_device.h"

namespace tandem::haptics {

struct VirtualStylusSettings {
  double smoothingTime = 0.03;   // s: the filter's 1/omega
  double maxSpeed = 2.0;         // m/s of the target; scale it with a scene much larger than a table
  double workspaceRadius = 0.2;  // m, as reported in limits()
  // Steadier and better damped than a relaxed adult's arm, because a mouse has no mass that would steady it.
  ArmParameters arm{
      .mass = 0.5, .stiffness = 300.0, .damping = 20.0, .gripStiffness = 800.0, .gripDamping = 10.0};
  SimulatedDeviceParameters device;
};

/// A pose that follows another one with critical damping. Pure; exact for a resting target, stable for every
/// dt.
class PoseFilter {
 public:
  explicit PoseFilter(const Pose& start) : pose_(start) {}

  /// Advances by dt s towards `target` with time constant `time` (s) and at most `maxSpeed` (m/s).
  void step(const Pose& target, double time, double maxSpeed, double dt);

  /// Puts the filter at rest at a pose.
  void reset(const Pose& pose);

  const Pose& pose() const { return pose_; }
  const Twist& twist() const { return twist_; }
  const glm::dvec3& acceleration() const { return acceleration_; }

 private:
  Pose pose_;
  Twist twist_;
  glm::dvec3 acceleration_{0.0, 0.0, 0.0};
};

class VirtualStylus : public HandDevice {
 public:
  explicit VirtualStylus(const Pose& worldFromStart = {}, const VirtualStylusSettings& settings = {});

  std::string name() const override { return "stylus"; }

  /// Pose at which the mouse points, world. Ignored if not finite; the orientation is normalised.
  void setTarget(const glm::dvec3& worldPosition,
                 const glm::dquat& orientation = glm::dquat(1.0, 0.0, 0.0, 0.0));
  /// Bit 0 grasps, bit 1 is the clutch.
  void setButtons(std::uint32_t buttons) { buttons_.store(buttons, std::memory_order_relaxed); }

 private:
  HandTarget nextTarget(double dt) override;
  std::uint32_t pressedButtons() const override { return buttons_.load(std::memory_order_relaxed); }

  VirtualStylusSettings settings_;
  PoseFilter filter_;
  TripleBuffer<Pose> target_;
  std::atomic<std::uint32_t> buttons_{0};
};

}  // namespace tandem::haptics
