#pragma once

// Interface between HID drivers and the bus: hidapi implements it in the program, a script in tests.
//
// Threads: a HidBus from any thread. A HidConnection from one thread at a time, never the servo thread,
// because reads wait.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "assets/base/result.h"

namespace tandem::haptics {

inline constexpr std::size_t kLongestReport = 4096;  // bytes, its id included

/// One HID interface as the bus reports it.
struct HidInfo {
  std::string path;  // the node to open, /dev/hidrawN on Linux
  std::uint16_t vendor = 0, product = 0;
  std::string manufacturer, productName, serial;
  std::uint16_t usagePage = 0, usage = 0;  // of its first collection; 0 when unknown
};

class HidConnection {
 public:
  virtual ~HidConnection() = default;
  /// Waits for one input report: its length (report id first), 0 if none came in time, -1 if the device is
  /// gone.
  virtual int read(std::span<std::uint8_t> buffer, int timeout_ms) = 0;
  /// Sends an output report, its id first.
  virtual Status write(std::span<const std::uint8_t> report) = 0;
  /// Sends a feature report, its id first.
  virtual Status sendFeature(std::span<const std::uint8_t>) { return Error{"HID: no feature reports here"}; }
  /// Requests the feature report whose id is in report[0]; returns its length, id included.
  virtual Result<std::size_t> getFeature(std::span<std::uint8_t>) {
    return Error{"HID: no feature reports here"};
  }
  /// The report descriptor, as the device gave it to the kernel.
  virtual Result<std::vector<std::uint8_t>> descriptor() { return Error{"HID: no report descriptor here"}; }
};

class HidBus {
 public:
  virtual ~HidBus() = default;
  /// What is connected, each path once.
  virtual std::vector<HidInfo> enumerate() = 0;
  virtual Result<std::unique_ptr<HidConnection>> open(const std::string& path) = 0;
  /// The report descriptor of an interface without opening it, so that a device without permission can still
  /// be identified.
  virtual Result<std::vector<std::uint8_t>> descriptor(const std::string&) {
    return Error{"HID: no report descriptor here"};
  }
  /// Whether opening the node now fails for lack of permission.
  virtual bool forbids(const std::string&) { return false; }
  /// Whether the node still exists: cheaper than enumerate().
  virtual bool present(const std::string& path) = 0;
};

/// The machine's HID devices, through hidapi. Lives as long as the program.
HidBus& systemHidBus();

}  // namespace tandem::haptics
