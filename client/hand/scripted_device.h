#pragma once

// A device in the hand of a scripted person: script, arm and device models in one, on whatever time it is
// polled with. Used by simulations (virtual time) and by `tandem join --hand` (real time).

#include <atomic>
#include <functional>

#include "client/hand/hand_script.h"
#include "haptics/base/device.h"
#include "haptics/operator/simulated_hand.h"

namespace tandem::client {

class ScriptedDevice : public haptics::Device {
 public:
  using WorldFromPart = std::function<Pose(PartId)>;

  /// `worldFromPart` is asked in poll(), in its thread, when a step begins.
  ScriptedDevice(const assets::Scene& scene, HandScript script, const haptics::ArmParameters& arm,
                 const haptics::SimulatedDeviceParameters& device, const Pose& worldFromStart,
                 WorldFromPart worldFromPart);

  std::string name() const override { return "scripted hand"; }
  haptics::DeviceLimits limits() const override;
  Status open() override { return {}; }
  void close() override {}
  /// Advances the person, arm and device from the last poll to `now` s under the applied force. The script's
  /// time 0 is the first poll.
  haptics::DeviceSample poll(double now) override;
  void apply(const Wrench& toHand) override { force_ = toHand.force; }

  const haptics::SimulatedHand& hand() const { return hand_; }
  const haptics::HandTarget& target() const { return intent_.target; }
  PartId wish() const { return intent_.wish; }
  const ControlWish& control() const { return intent_.control; }
  /// Steps so far that write in the document. Any thread.
  std::uint32_t written() const { return written_.load(std::memory_order_acquire); }
  bool finished() const { return person_.finished(elapsed_); }

 private:
  ScriptedPerson person_;
  haptics::SimulatedDeviceParameters device_;
  haptics::SimulatedHand hand_;
  WorldFromPart worldFromPart_;
  ScriptedPerson::Intent intent_;
  glm::dvec3 force_{0.0, 0.0, 0.0};
  double start_ = 0.0, elapsed_ = 0.0;
  bool started_ = false;
  std::atomic<std::uint32_t> written_{0};
};

/// Where a hand begins when nothing says otherwise: in front of and above the scene, the n-th hand beside the
/// others.
Pose defaultHandStart(const assets::Scene& scene, std::size_t n);

}  // namespace tandem::client
