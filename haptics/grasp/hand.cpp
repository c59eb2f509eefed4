#include "haptics/grasp/hand.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>

namespace tandem::haptics {
namespace {

// A hand that moved less than this while the ticks stood still keeps its contacts.
constexpr double kStillInStall = 1e-3;  // m
// Time constant, s, of the memory of the fastest recent tick. A device that is read less often than the loop
// ticks, or that measures in coarse steps, seems to stand still in most ticks.
constexpr double kWayDecay = 0.01;

}  // namespace

void Hand::begin(const HandInput& input, const TickParameters& parameters) {
  parameters_ = parameters;
  flags_ = 0;
  lastTool_ = std::exchange(tool_, input.tool);
  motion_ = displacement_ = rotation_ = glm::dvec3(0.0);
  elsewhere_ = false;
  silence_ = invalidTime_;
  const DeviceSample& reading = input.device;
  const SampleGuard::Verdict verdict = guard_.judge(reading, parameters_, invalidTime_, flags_);
  valid_ = verdict != SampleGuard::Verdict::refused;
  if (!valid_) {
    flags_ |= kFlagInvalidSample;
    invalidTime_ += parameters_.dt;
    return;
  }
  const Pose &now = reading.worldFromDevice, &last = device_.worldFromDevice;
  if (started_) motion_ = now.position - last.position;
  if (started_ && (hasTool_ || fade_.active())) displacement_ = now.position - last.position;
  if (started_ && fade_.active())
    rotation_ = rotationVector(now.orientation * glm::conjugate(last.orientation));
  way_ = std::max({glm::length(motion_), parameters_.dt * glm::length(reading.twist.linear),
                   way_ * std::exp(-parameters_.dt / kWayDecay)});
  device_ = steadyDevice_ = reading;
  if (reading_.note(now.position, parameters_.dt)) steadyDevice_.twist.linear = glm::dvec3(0.0);
  const bool wentOn = std::exchange(stalled_, false) && glm::length(displacement_) > kStillInStall;
  elsewhere_ = wentOn || verdict == SampleGuard::Verdict::elsewhere;
  started_ = true;
  invalidTime_ = 0.0;
}

/// No more than this fades: the hand never got more, and a part that it takes from under a larger force
/// would be dragged by the rest.
Wrench Hand::withinLimits(const Wrench& wrench) const {
  const double force = glm::length(wrench.force), torque = glm::length(wrench.torque);
  return {wrench.force * std::min(1.0, parameters_.forceLimit / std::max(force, 1e-300)),
          wrench.torque * std::min(1.0, parameters_.torqueLimit / std::max(torque, 1e-300))};
}

void Hand::fadeOut(const Wrench& ended, const Fade::Stiffness& stiffness) {
  fade_.start(hasTool_ ? withinLimits(ended) : ended, stiffness, parameters_.fadeTime);
}

void Hand::bridge(const glm::dvec3& last, const glm::dvec3& now, double spring) {
  const glm::dvec3 felt = withinLimits({last - arrival_.heldBack(last, 0.0), glm::dvec3(0.0)}).force;
  const double square = glm::dot(now, now);
  const double share = square > 0.0 ? std::clamp(glm::dot(felt, now) / square, 0.0, 1.0) : 0.0;
  const glm::dvec3 ended = felt - share * now;
  arrival_.start((1.0 - share) * now);
  // A spring with the energy that the contact has lost.
  const double lost = glm::dot(felt, felt) - share * share * square;
  if (!(lost > 0.0)) return;
  const double fading = glm::length(fade_.now().force + ended);
  fade_.start({ended, glm::dvec3(0.0)}, {spring * glm::dot(ended, ended) / lost, 0.0},
              std::max(parameters_.fadeTime, fading / kGentleFade));
}

void Hand::endCoupling(double springs) {
  fadeOut(coupling_, {springs * parameters_.graspStiffness, springs * parameters_.graspRotStiffness});
  coupling_ = Wrench{};
}

Wrench Hand::send(const Wrench* touches, const ForceCause& cause, FaultLatch& fault) {
  if (fade_.active()) fade_.advance(displacement_, rotation_, parameters_.dt);
  const Wrench lasting = touches != nullptr ? *touches + coupling_ : coupling_;
  const Wrench wanted = lasting + fade_.now();
  const Wrench toHand =
      limitOutput(wanted, valid_ ? &device_ : nullptr, cause, parameters_, fault, limits_, flags_);
  sentShare_ = shareOf(wanted.force);
  return toHand;
}

double Hand::shareOf(const glm::dvec3& wanted) const {
  if (!valid_ || parameters_.zeroForce) return 0.0;
  const double square = glm::dot(wanted, wanted);
  if (!(square > 0.0)) return std::clamp(parameters_.gain, 0.0, 1.0);
  return std::clamp(glm::dot(limits_.sent.force, wanted) / square, 0.0, 1.0);
}

}  // namespace tandem::haptics
