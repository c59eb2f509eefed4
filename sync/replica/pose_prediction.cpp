#include "sync/replica/pose_prediction.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "assets/base/assert.h"

namespace tandem::sync {
namespace {

constexpr double kBlendTime = 0.02;                  // s
constexpr double kAccelerationTime = 0.04;           // s
constexpr Micros kBeyondUsual = 60 * kMillisecond;   // past the usual age the part is extrapolated no further
constexpr double kAgeShare = 0.1;                    // weight of a new age in the average
constexpr double kUnseen = 1e-6;                     // m
constexpr double kUnseenTurn = 1e-5;                 // rad
constexpr Micros kLongestStep = 100 * kMillisecond;  // between two states that give an acceleration

}  // namespace

bool PosePrediction::near(const Pose& a, const Pose& b) {
  return glm::length(a.position - b.position) < kUnseen &&
         glm::length(rotationVector(a.orientation * glm::conjugate(b.orientation))) < kUnseenTurn;
}

void PosePrediction::restart(const Pose& worldFromPart, Micros now) {
  *this = PosePrediction{};
  newest_.worldFromPart = drawn_ = worldFromPart;
  drawnBefore_ = true;
  drawnAt_ = now;
}

void PosePrediction::push(const PartState& state, Micros time) {
  if (known_ && time <= time_) return;
  const double step = toSeconds(time - time_);
  ASSERT(!known_ || step > 0.0);
  const bool near = known_ && time - time_ <= kLongestStep;
  const glm::dvec3 rate = near ? (state.twist.linear - newest_.twist.linear) / step : glm::dvec3(0.0);
  const double share = near ? 1.0 - std::exp(-step / kAccelerationTime) : 1.0;
  acceleration_ += share * (rate - acceleration_);
  if (isStill(state.twist)) acceleration_ = {};
  newest_ = state;
  time_ = time;
  known_ = true;
  if (!drawnBefore_) return;
  const auto age = static_cast<double>(std::clamp<Micros>(drawnAt_ - time_, 0, kFarthest));
  usualAge_us_ = usualAge_us_ == 0.0 ? age : usualAge_us_ + kAgeShare * (age - usualAge_us_);
  const Pose now = carriedOn(drawnAt_);
  offset_ = drawn_.position - now.position;
  turnedOff_ = rotationVector(drawn_.orientation * glm::conjugate(now.orientation));
}

void PosePrediction::standAt(const Pose& worldFromPart, Micros now) {
  time_ = std::min(time_, now - 1);
  PartState state;
  state.worldFromPart = worldFromPart;
  push(state, now);
}

Pose PosePrediction::carriedOn(Micros now) const {
  if (!known_) return newest_.worldFromPart;
  const Micros farthest = std::min(kFarthest, static_cast<Micros>(usualAge_us_) + kBeyondUsual);
  const double elapsed = toSeconds(std::clamp<Micros>(now - time_, 0, farthest));
  Pose pose = integrate(newest_.worldFromPart, newest_.twist, elapsed);
  // A part that brakes comes to rest: the acceleration is applied only until the speed is zero.
  const double speed = glm::length(newest_.twist.linear);
  const double along = speed > 0.0 ? glm::dot(acceleration_, newest_.twist.linear) / speed : 0.0;
  const double braked = along < 0.0 ? std::min(elapsed, -speed / along) : elapsed;
  ASSERT(braked >= 0.0 && braked <= elapsed);
  pose.position += newest_.twist.linear * (braked - elapsed) + 0.5 * braked * braked * acceleration_;
  return pose;
}

Pose PosePrediction::at(Micros now) {
  if (drawnBefore_) {
    const double left = std::exp(-toSeconds(std::max<Micros>(0, now - drawnAt_)) / kBlendTime);
    offset_ *= left;
    turnedOff_ *= left;
  }
  drawn_ = carriedOn(now);
  drawn_.position += offset_;
  drawn_.orientation = glm::normalize(fromRotationVector(turnedOff_) * drawn_.orientation);
  drawnBefore_ = true;
  drawnAt_ = now;
  return drawn_;
}

}  // namespace tandem::sync
