#include "haptics/safety/foreign_guard.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

namespace tandem::haptics {
namespace {

constexpr double kStays = 0.05;           // s that the guard goes on after the last foreign motion
constexpr double kSwings = 1.0;           // s, the same where it has struck a held part
constexpr double kRestless = 1.0;         // s
constexpr double kCalm = 1.0;             // of the slew limit, that a calm part's motion may take
constexpr double kCreditTime = 0.01;      // s, time constant of the hand's credit
constexpr double kFlicker = 0.05;         // N of credit that the flicker of a reading may leave
constexpr double kVelocityTime = 0.02;    // s
constexpr double kNothing = 1e-9;         // N and N·m
constexpr double kTorquePerForce = 0.06;  // m: the torque's slew limit as a share of the force's

glm::dvec3 shortened(const glm::dvec3& v, double most) {
  const double length = glm::length(v);
  return length > most ? v * (most / length) : v;
}

}  // namespace

Wrench ForeignGuard::step(const Wrench& wanted, const Tick& tick, const TickParameters& parameters,
                          std::uint32_t& flags) {
  const ForeignLimits& limits = parameters.foreign;
  const double dt = parameters.dt;
  if (!counts_) account_ = limits.energy;
  counts_ = true;
  account_ = std::min(limits.energy, account_ + limits.refill * dt);
  const bool fast = tick.foreign * tick.stiffness > kCalm * limits.slew * dt;
  restless_ = fast ? kRestless : std::max(0.0, restless_ - dt);
  const bool acts = tick.foreign >= 0.0 || (tick.touches && restless_ > 0.0);
  engaged_ = std::max(acts ? tick.held ? kSwings : kStays : 0.0, engaged_ - dt);
  const Wrench within{shortened(wanted.force, parameters.forceLimit),
                      shortened(wanted.torque, parameters.torqueLimit)};
  if (engaged_ == 0.0 || !(limits.slew > 0.0)) {
    sent_ = within;
    credit_ = glm::dvec3(0.0);
    along_ = 0.0;
    return wanted;
  }
  Wrench passed{force(within.force, tick, parameters), within.torque};
  passed.torque = sent_.torque + shortened(within.torque - sent_.torque, kTorquePerForce * limits.slew * dt);
  const double back = glm::length(within.force - passed.force) + glm::length(within.torque - passed.torque);
  if (back > kNothing) {
    flags |= kFlagForeignLimited;
    engaged_ = std::max(engaged_, 2.0 * dt);  // until nothing is held back
  }
  sent_ = passed;
  return passed;
}

/// N: from this force the hand can be let go at the slew rate without being given more than the account.
double ForeignGuard::mostForce(double stiffness, const TickParameters& parameters) const {
  const double needed = 1.0 / stiffness + std::max(0.0, along_) / parameters.foreign.slew;
  return std::sqrt(2.0 * std::max(0.0, account_) / needed);
}

glm::dvec3 ForeignGuard::force(const glm::dvec3& wanted, const Tick& tick, const TickParameters& parameters) {
  const double dt = parameters.dt, step = parameters.foreign.slew * dt;
  const glm::dvec3& d = tick.displacement;
  const double last = glm::length(sent_.force);
  account_ = std::min(parameters.foreign.energy, account_ - glm::dot(sent_.force, d));
  const double speed = last > kNothing ? glm::dot(sent_.force, d) / (last * dt) : 0.0;
  along_ += std::min(1.0, dt / kVelocityTime) * (speed - along_);

  const glm::dvec3 made = -tick.stiffness * d;
  credit_ = shortened(credit_ * (1.0 - dt / kCreditTime) + made, std::max(kFlicker, glm::length(made)));
  const glm::dvec3 goal = shortened(wanted, mostForce(tick.stiffness, parameters));
  const glm::dvec3 change = goal - sent_.force;
  const double length = glm::length(change);
  if (!(length > 0.0)) return goal;
  const glm::dvec3 direction = change / length;
  const double byHand = restless_ > 0.0 ? 0.0 : std::max(0.0, glm::dot(credit_, direction));
  const double taken = std::min(length, std::max(step, byHand));
  credit_ -= std::min(taken, byHand) * direction;
  return taken < length ? sent_.force + taken * direction : goal;
}

}  // namespace tandem::haptics
