#include "haptics/safety/sample_guard.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

namespace tandem::haptics {
namespace {

// Beyond this a reading is garbage, whatever the scene: what is computed from it would overflow.
constexpr double kAbsurd = 1e12;  // m, m/s, rad/s

bool plausible(const glm::dvec3& v) {
  return std::abs(v.x) < kAbsurd && std::abs(v.y) < kAbsurd && std::abs(v.z) < kAbsurd;  // false for nan
}

bool usable(const DeviceSample& sample) {
  return sample.valid && isValid(sample.worldFromDevice) && plausible(sample.worldFromDevice.position) &&
         plausible(sample.twist.linear) && plausible(sample.twist.angular);
}

}  // namespace

SampleGuard::Verdict SampleGuard::judge(const DeviceSample& sample, const TickParameters& parameters,
                                        double silence, std::uint32_t& flags) {
  if (!usable(sample)) return Verdict::refused;
  if (stale(sample, parameters)) {
    flags |= kFlagStaleSample;
    return Verdict::refused;
  }
  const Verdict verdict =
      judgePlace(sample.worldFromDevice.position, parameters.maxDeviceSpeed, parameters.dt, silence, flags);
  if (verdict == Verdict::refused) return verdict;
  started_ = true;
  candidateTicks_ = 0;
  good_ = sample.worldFromDevice.position;
  return verdict;
}

bool SampleGuard::stale(const DeviceSample& sample, const TickParameters& parameters) {
  if (std::isfinite(sample.time)) latest_ = std::max(latest_, sample.time);
  if (sample.time == 0.0 || latest_ > newest_) {
    newest_ = latest_;
    age_ = waited_ = 0.0;
    return false;
  }
  age_ += parameters.dt;
  waited_ += parameters.dt;
  if (waited_ > parameters.staleAfter) {
    newest_ = latest_;
    latest_ = kNever;
    waited_ = 0.0;
  }
  return parameters.staleAfter > 0.0 && age_ > parameters.staleAfter;
}

SampleGuard::Verdict SampleGuard::judgePlace(const glm::dvec3& place, double speed, double dt, double silence,
                                             std::uint32_t& flags) {
  if (!started_ || !(speed > 0.0) || glm::length(place - good_) <= speed * (silence + dt)) {
    return Verdict::good;
  }
  const bool stays = candidateTicks_ > 0 && glm::length(place - candidate_) <= speed * dt;
  candidate_ = place;
  candidateTicks_ = stays ? candidateTicks_ + 1 : 1;
  if (candidateTicks_ > kJumpTicks) return Verdict::elsewhere;
  flags |= kFlagSampleJump;
  return Verdict::refused;
}

}  // namespace tandem::haptics
