#pragma once

// Hand steered by rate control: deflection is velocity, as seen on the screen. Common to input devices whose
// motors, if any, cannot push the hand. The force acts on a simulated hand, which therefore stops at
// surfaces.
//
// Threads: setView() from one thread, any time; the rest from the servo thread.

#include "haptics/base/triple_buffer.h"
#include "haptics/operator/hand_device.h"

namespace tandem::haptics {

/// View parameters: the orientation of the screen and the size of the scene.
struct SteeringView {
  glm::dquat worldFromView{1.0, 0.0, 0.0, 0.0};
  double maxSpeed = 0.15;  // m/s at full deflection; about the scene's size per second
};

class SteeredHand : public HandDevice {
 public:
  /// Ignored if not finite or without a unit quaternion.
  void setView(const SteeringView& view);

  /// Forces move only the simulated hand: actuatedAxes is 0 although maxForce is not.
  DeviceLimits limits() const override;

 protected:
  explicit SteeredHand(const Pose& worldFromStart);

  /// Sets the wanted velocity, world; it reaches the hand smoothed over 20 ms.
  void steer(const Twist& wanted) { wanted_ = wanted; }
  const SteeringView& view() { return view_.latest(); }

 private:
  HandTarget nextTarget(double dt) override;

  TripleBuffer<SteeringView> view_;
  Twist wanted_, twist_;
  Pose target_;
};

}  // namespace tandem::haptics
