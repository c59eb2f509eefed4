#pragma once

// A Haply Inverse3 through its vendor's device service, which runs on the same machine and speaks JSON over a
// WebSocket (haply_codec.h). This is the only socket in this folder, and it leads to a device, not to a peer.
//
// 1. A separate thread answers each message of the service with the latest force; without an answer the
//    service sends no more.
// 2. The force is zero once apply() has not been called for 50 ms, and in the last message before closing.
// 3. A malformed, non-finite or too long message is dropped and counted, and still answered. Readings are
//    invalid after 50 ms without a good message.
// 4. The connection to a lost service is retried five times a second.
//
// Axes: x right, y up, z towards the user; the origin is the device's. Threads: poll() and apply() from the
// servo thread.

#include <memory>
#include <string>

#include "haptics/base/device.h"

namespace tandem::haptics {

struct HaplySettings {
  std::string host = "localhost";
  std::uint16_t port = 10001;
  double maxForce = 5.0;  // N: below the arm's peak, so that it can hold it for long
};

/// Parses `haply`, `haply:HOST` or `haply:HOST:PORT`.
Result<HaplySettings> parseHaplyName(const std::string& name);

/// Checks whether a service listens there; the error is the reason if not.
Status probeHaply(const HaplySettings& settings);

struct HaplyReading {
  glm::dvec3 position{0.0, 0.0, 0.0}, velocity{0.0, 0.0, 0.0};  // m, m/s
  glm::dquat orientation{1.0, 0.0, 0.0, 0.0};
  std::uint32_t buttons = 0;
  double at = -1e9;             // s, steady clock: when it came
  std::uint64_t states = 0;     // good messages so far
  std::uint64_t malformed = 0;  // dropped
  std::uint64_t oversized = 0;  // dropped together with the connection
  std::uint64_t connections = 0;
  bool connected = false, present = false;  // to the service; an Inverse3 at the service
};

class HaplyDevice : public Device {
 public:
  explicit HaplyDevice(const HaplySettings& settings = {});
  ~HaplyDevice() override;  // closes

  std::string name() const override { return "haply"; }
  DeviceLimits limits() const override;
  /// Waits for the service for at most two seconds.
  Status open() override;
  void close() override;
  DeviceSample poll(double now) override;
  void apply(const Wrench& toHand) override;

  /// The reading of the last poll(); servo thread.
  const HaplyReading& reading() const { return reading_; }

 private:
  struct Driver;
  HaplySettings settings_;
  std::unique_ptr<Driver> driver_;
  HaplyReading reading_;
};

}  // namespace tandem::haptics
