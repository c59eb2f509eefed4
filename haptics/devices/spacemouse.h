#pragma once

// A SpaceMouse moves a simulated hand by rate control: deflection is velocity. The fingers feel no force; the
// force acts on the simulated hand, which therefore stops at surfaces and whose target never runs far ahead
// into a part.
//
// 1. A separate thread reads reports (60 to 125 a second) and hands over the latest state by triple buffer.
// 2. The device sends only while it moves, so the deflection counts as zero after 100 ms of silence.
// 3. Samples of an unplugged device are invalid; replugged (to any port) it continues from the hand's pose.

#include <memory>

#include "haptics/base/triple_buffer.h"
#include "haptics/devices/hid_transport.h"
#include "haptics/devices/spacemouse_decoder.h"
#include "haptics/operator/steered_hand.h"

namespace tandem::haptics {

/// Latest state of the reader thread.
struct SpaceMouseReading {
  SpaceMouseState state;
  std::uint64_t reports = 0;   // accepted so far
  std::uint64_t rejected = 0;  // of unknown layout
  bool connected = false;
};

/// The driver on its HidWorker. open() and close() from one thread; reading() from one, the servo
/// thread.
class SpaceMouseReader {
 public:
  explicit SpaceMouseReader(HidBus& bus);
  ~SpaceMouseReader();  // closes

  /// Finds and opens the first SpaceMouse and starts to read it; the error says what is missing.
  Status open();
  /// Ends the thread and switches the light off. Idempotent.
  void close();
  const SpaceMouseReading& reading();

 private:
  struct Driver;
  std::unique_ptr<Driver> driver_;
};

/// Whether an interface is the motion interface of a known model; receivers also have a mouse and a keyboard.
bool isSpaceMouse(const HidInfo& info);

class SpaceMouse : public SteeredHand {
 public:
  explicit SpaceMouse(HidBus& bus, const Pose& worldFromStart = {});
  ~SpaceMouse() override;

  std::string name() const override { return "spacemouse"; }
  Status open() override;
  void close() override;
  DeviceSample poll(double now) override;

 private:
  void beginPoll(double now) override;
  std::uint32_t pressedButtons() const override { return reading_.connected ? reading_.state.buttons : 0; }

  SpaceMouseReader reader_;
  VelocityCurve curve_;
  SpaceMouseReading reading_;
  double lastNews_ = 0.0;
};

}  // namespace tandem::haptics
