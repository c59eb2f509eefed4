#pragma once

// A device with readings in its own axes, placed in the scene by a DeviceMapping: by a calibration, or such
// that its first reading becomes a given point. The clutch (button 1) shifts it.
//
// Threads: those of the device.

#include <memory>
#include <optional>

#include "assets/base/assert.h"
#include "haptics/devices/device_mapping.h"

namespace tandem::haptics {

class PlacedDevice : public Device {
 public:
  PlacedDevice(std::unique_ptr<Device> device, const DeviceMapping& mapping,
               const std::optional<glm::dvec3>& firstAt = std::nullopt)
      : device_(std::move(device)), mapping_(mapping), firstAt_(firstAt) {
    ASSERT(device_ != nullptr);
  }

  std::string name() const override { return device_->name(); }
  DeviceLimits limits() const override { return mapping_.inWorld(device_->limits()); }
  Status open() override { return device_->open(); }
  void close() override { device_->close(); }
  DeviceSample poll(double now) override {
    const DeviceSample sample = device_->poll(now);
    if (firstAt_ && sample.valid) {
      mapping_.recentre(sample, *firstAt_);
      firstAt_.reset();
    }
    return mapping_.toWorld(sample);
  }
  void apply(const Wrench& toHand) override { device_->apply(mapping_.toDevice(toHand)); }

 private:
  std::unique_ptr<Device> device_;
  DeviceMapping mapping_;
  std::optional<glm::dvec3> firstAt_;
};

}  // namespace tandem::haptics
