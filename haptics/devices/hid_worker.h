#pragma once

// Thread of a HID driver: finds its device, opens it, reads it, lets the driver send what is due, and
// searches for it again after it was unplugged.
//
// Threads: open() and close() from one thread. The client is called from open() and then from the worker's
// thread, never from two threads at once.

#include <chrono>
#include <memory>
#include <string>

#include "haptics/devices/hid_transport.h"

namespace tandem::haptics {

/// The driver's part.
class HidClient {
 public:
  virtual ~HidClient() = default;
  virtual const char* what() const = 0;  // for errors: "dualsense"
  virtual bool serves(const HidInfo& info) const = 0;
  /// Initialises a freshly opened device.
  virtual Status begin(HidConnection& connection, const HidInfo& info) = 0;
  /// An input report.
  virtual void report(std::span<const std::uint8_t> bytes) = 0;
  /// Runs between two reads, at least every readTimeout_ms(), and sends what is due. An error means that the
  /// device is gone.
  virtual Status service(HidConnection& connection) = 0;
  /// Runs before an intentional close: leaves the device without force.
  virtual void end(HidConnection& connection) = 0;
  virtual void lost() = 0;
  virtual int readTimeout_ms() const { return 1; }
};

class HidWorker {
 public:
  HidWorker(HidBus& bus, HidClient& client);
  ~HidWorker();  // closes

  /// Opens the first device that the client serves and starts the thread; the error says what is missing. A
  /// node without permission is retried for 0.6 s, because udev sets the permissions of a device just plugged
  /// in. The thread retries forever, and reports missing permission once on standard error.
  Status open();
  /// Ends the thread. Idempotent.
  void close();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Seconds on the clock of a driver's thread (std::chrono::steady_clock, like the servo loop's).
double driverClock();

}  // namespace tandem::haptics
