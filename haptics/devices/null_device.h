#pragma once

// Null device: no input, no force. For sites that only watch. Always built.

#include "haptics/base/device.h"

namespace tandem::haptics {

class NullDevice : public Device {
 public:
  std::string name() const override { return "none"; }
  DeviceLimits limits() const override;
  Status open() override { return {}; }
  void close() override {}
  /// Never valid: there is no hand.
  DeviceSample poll(double now) override;
  void apply(const Wrench&) override {}
};

}  // namespace tandem::haptics
