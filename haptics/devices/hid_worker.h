#pragma once

// The thread of a HID driver: finds its device, opens it, reads it, lets the driver send what is due, and
// looks for it again after it was unplugged.
//
// Threads: open() and close() from one thread. The client is called from open() and then from the worker's
// thread, never from two at once.

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
  /// Brings a freshly opened device to where it can be used.
  virtual Status begin(HidConnection& connection, const HidInfo& info) = 0;
  /// An input report.
  virtual void report(std::span<const std::uint8_t> bytes) = 0;
  /// Between two reads, at least every readTimeout_ms(): sends what is due. An error means the device is
  /// gone.
  virtual Status service(HidConnection& connection) = 0;
  /// Before the connection is closed on purpose: leaves the device without force.
  virtual void end(HidConnection& connection) = 0;
  virtual void lost() = 0;
  virtual int readTimeout_ms() const { return 1; }
};

class HidWorker {
 public:
  HidWorker(HidBus& bus, HidClient& client);
  ~HidWorker();  // closes

  /// Opens the first device that the client serves and starts the thread; the error says what is missing.
  /// A node that may not be opened is tried again for 0.6 s: udev sets the permissions of a device just
  /// plugged in. The thread tries for ever, and says once on standard error when permission stays missing.
  Status open();
  /// Ends the thread. Idempotent.
  void close();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Seconds on the clock that a driver's thread uses (std::chrono::steady_clock, as the servo loop's).
double driverClock();

}  // namespace tandem::haptics
