#pragma once

// A DualSense steers a simulated hand and lets the fingers feel its contacts: left stick right and back,
// right stick up, gyro while R1 is held. The triggers resist as the force on the hand grows, and a rumble
// marks each contact. The controller cannot push the hand: the force moves the simulated one.
//
// Cross or the right trigger grasps, circle is the clutch. Output goes over USB or Bluetooth, on change, at
// most 250 times a second, and is switched off after 50 ms without a call of apply().
//
// Threads: poll() and apply() from the servo thread; setView() from one thread.

#include <memory>

#include "haptics/devices/dualsense_codec.h"
#include "haptics/devices/hid_transport.h"
#include "haptics/operator/steered_hand.h"

namespace tandem::haptics {

/// Latest state of the driver's thread.
struct DualSenseReading {
  DualSenseState state;
  GyroCalibration gyro;
  std::uint64_t reports = 0, rejected = 0, written = 0;
  bool connected = false;
};

/// Whether an interface is the gamepad of a DualSense or DualSense Edge.
bool isDualSense(const HidInfo& info);
/// Its name, or null.
const char* dualSenseName(std::uint16_t vendor, std::uint16_t product);

class DualSense : public SteeredHand {
 public:
  explicit DualSense(HidBus& bus, const Pose& worldFromStart = {});
  ~DualSense() override;  // closes

  std::string name() const override { return "dualsense"; }
  Status open() override;
  void close() override;
  DeviceSample poll(double now) override;
  void apply(const Wrench& toHand) override;

  /// The latest reading; servo thread.
  const DualSenseReading& reading() const { return reading_; }

 private:
  struct Driver;
  void beginPoll(double now) override;
  std::uint32_t pressedButtons() const override;

  std::unique_ptr<Driver> driver_;
  DualSenseReading reading_;
  GripCues cues_;
  double lastPoll_ = 0.0, interval_ = 0.0;
};

}  // namespace tandem::haptics
