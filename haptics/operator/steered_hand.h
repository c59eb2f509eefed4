#pragma once

// A hand that is steered by speed: deflection is velocity, as seen on the screen. Common to input devices
// whose motors, if any, cannot push the hand: the force acts on a simulated hand, which therefore stops at
// surfaces.
//
// Threads: setView() from one thread, any time; the rest from the servo thread.

#include "haptics/base/triple_buffer.h"
#include "haptics/operator/hand_device.h"

namespace tandem::haptics {

/// What the viewer decides: which way is right on the screen, and how large the scene is.
struct SteeringView {
  glm::dquat worldFromView{1.0, 0.0, 0.0, 0.0};
  double maxSpeed = 0.15;  // m/s at full deflection; about the scene's size a second
};

class SteeredHand : public HandDevice {
 public:
  /// Not finite or not a unit quaternion: ignored.
  void setView(const SteeringView& view);

  /// Forces move the simulated hand only: actuatedAxes is 0 although maxForce is not.
  DeviceLimits limits() const override;

 protected:
  explicit SteeredHand(const Pose& worldFromStart);

  /// The speed wanted from now on, world; smoothed over 20 ms on its way to the hand.
  void steer(const Twist& wanted) { wanted_ = wanted; }
  const SteeringView& view() { return view_.latest(); }

 private:
  HandTarget nextTarget(double dt) override;

  TripleBuffer<SteeringView> view_;
  Twist wanted_, twist_;
  Pose target_;
};

}  // namespace tandem::haptics
