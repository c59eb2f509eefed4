#pragma once

// Recording of a HID device's reports in a text file, to reproduce a device that is not at hand.
//
//   device 046d:c62b 1:8 SpaceMouse Pro        vendor:product usage page:usage (hex), name; no serial number
//   descriptor 05010908...                     the report descriptor, if there was one
//   feature 05...                              a feature report as the device gave it, id first
//   in 0.012345 01a0ff...                      an input report, id first, and s since the recording began
//
// Threads: those of the recorded bus.

#include <memory>
#include <string>
#include <vector>

#include "haptics/devices/hid_transport.h"

namespace tandem::haptics {

/// A bus that forwards to another bus and records what the opened device sends.
class RecordingHidBus : public HidBus {
 public:
  /// Makes the file; the error says why it cannot. `bus` must outlive this and every connection.
  static Result<std::unique_ptr<RecordingHidBus>> create(HidBus& bus, const std::string& file);
  ~RecordingHidBus() override;

  std::vector<HidInfo> enumerate() override;
  Result<std::unique_ptr<HidConnection>> open(const std::string& path) override;
  Result<std::vector<std::uint8_t>> descriptor(const std::string& path) override;
  bool forbids(const std::string& path) override;
  bool present(const std::string& path) override;

  /// Ends the recording; returns the number of input reports, or why the file could not be written. All
  /// connections must be closed before.
  Result<std::uint64_t> finish();

 private:
  class Connection;
  class Writer;
  RecordingHidBus(HidBus& bus, std::shared_ptr<Writer> writer);
  HidBus& bus_;
  std::shared_ptr<Writer> writer_;
};

struct HidRecording {
  struct Report {
    double time = 0.0;  // s since the recording began
    std::vector<std::uint8_t> bytes;
  };
  HidInfo info;
  std::vector<std::uint8_t> descriptor;             // empty: there was none
  std::vector<std::vector<std::uint8_t>> features;  // as they were given
  std::vector<Report> reports;                      // in the order of the file
};

/// Reads a recording's text; an error names `source`, the line and the reason.
Result<HidRecording> parseHidRecording(const std::string& text, const std::string& source);

}  // namespace tandem::haptics
