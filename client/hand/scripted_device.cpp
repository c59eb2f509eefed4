#include "client/hand/scripted_device.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

namespace tandem::client {

ScriptedDevice::ScriptedDevice(const assets::Scene& scene, HandScript script,
                               const haptics::ArmParameters& arm,
                               const haptics::SimulatedDeviceParameters& device, const Pose& worldFromStart,
                               WorldFromPart worldFromPart)
    : person_(scene, std::move(script), worldFromStart),
      device_(device),
      hand_(arm, device, worldFromStart),
      worldFromPart_(std::move(worldFromPart)) {}

haptics::DeviceLimits ScriptedDevice::limits() const {
  haptics::DeviceLimits limits;
  limits.sensedAxes = 6;
  limits.actuatedAxes = 3;
  limits.maxForce = device_.forceMax;
  limits.mass = device_.mass;
  limits.damping = device_.damping;
  limits.quantum = device_.quantum;
  return limits;
}

haptics::DeviceSample ScriptedDevice::poll(double now) {
  if (!started_) {
    started_ = true;
    start_ = now;
  }
  const double step = now - start_ - elapsed_;
  // A machine that stalled does not fling the arm: what was slept through is not simulated.
  constexpr double kLongestStep = 0.02;
  elapsed_ = now - start_;
  intent_ = person_.at(elapsed_, hand_.devicePose(), worldFromPart_);
  written_.store(intent_.written, std::memory_order_release);
  if (step > 0.0) hand_.step(intent_.target, force_, std::min(step, kLongestStep));
  haptics::DeviceSample sample = hand_.sample(now);
  if (intent_.graspButton) sample.buttons |= 1u;
  return sample;
}

Pose defaultHandStart(const assets::Scene& scene, std::size_t n) {
  const assets::Bounds& bounds = scene.bounds;
  const glm::dvec3 centre = 0.5 * (bounds.min + bounds.max);
  const double size = std::max(glm::length(bounds.max - bounds.min), 1e-6);
  const double side = (n % 2 == 0 ? -1.0 : 1.0) * (0.15 + 0.1 * static_cast<double>(n / 2));
  return {{centre.x + side * size, bounds.max.y + 0.15 * size, bounds.max.z + 0.1 * size},
          {1.0, 0.0, 0.0, 0.0}};
}

}  // namespace tandem::client
