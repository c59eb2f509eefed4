#pragma once

// A stylus that mouse and keyboard move: a simulated hand on a simulated desktop arm. Needs no hardware.
//
// The mouse speaks at 60 Hz: its target passes a critically damped filter, so that position, velocity and
// acceleration that reach the hand have no steps at 1 kHz. The hand then meets the applied force as a
// person's would: pressing against a wall, it stops there.
//
// Threads: setTarget(), setButtons() from one thread (the window's); poll() and apply() from the servo
// thread.

#include "haptics/base/triple_buffer.h"
#include "haptics/operator/hand_device.h"

namespace tandem::haptics {

struct VirtualStylusSettings {
  double smoothingTime = 0.03;   // s: the filter's 1/omega
  double maxSpeed = 2.0;         // m/s of the target; scale it with a scene much larger than a table
  double workspaceRadius = 0.2;  // m, as reported in limits()
  // A steadier, better damped arm than a relaxed adult's: a mouse has no weight that would calm it.
  ArmParameters arm{
      .mass = 0.5, .stiffness = 300.0, .damping = 20.0, .gripStiffness = 800.0, .gripDamping = 10.0};
  SimulatedDeviceParameters device;
};

/// A pose that follows another one critically damped. Pure; exact for a target that stands still, stable for
/// every dt.
class PoseFilter {
 public:
  explicit PoseFilter(const Pose& start) : pose_(start) {}

  /// Advances by dt s towards `target` with time constant `time` (s) and at most `maxSpeed` (m/s).
  void step(const Pose& target, double time, double maxSpeed, double dt);

  /// Puts the filter at rest somewhere.
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

  /// Where the mouse points, world. Not finite: ignored. Orientation is normalised.
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
