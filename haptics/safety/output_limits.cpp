#include "haptics/safety/output_limits.h"

#include <algorithm>

#include <glm/geometric.hpp>

#include "assets/base/finite.h"

namespace tandem::haptics {
namespace {

glm::dvec3 clampLength(const glm::dvec3& v, double limit, bool& clamped) {
  const double length = glm::length(v);
  if (length <= limit) return v;
  clamped = true;
  return v * (std::max(limit, 0.0) / length);
}

/// The limits' memory of the force or of the torque.
struct Channel {
  glm::dvec3 sent, within;  // of the last tick

  /// A change that the hand made: `wanted` less the part still held back, of which `step` is released.
  glm::dvec3 byHand(const glm::dvec3& wanted, double step, bool& slewed) const {
    const glm::dvec3 held = within - sent;
    const double length = glm::length(held);
    if (!(length > step)) return wanted;
    slewed = true;
    const glm::dvec3 along = held / length;
    const double goal = glm::dot(wanted, along), last = glm::dot(sent, along);
    const double now =
        std::clamp(goal - (length - step), std::min({0.0, goal, last}), std::max({0.0, goal, last}));
    return wanted + (now - goal) * along;
  }

  /// A change that others made, of at most `step` beyond any share of what the hand's own motion made.
  glm::dvec3 byOthers(const glm::dvec3& wanted, double step, const glm::dvec3& byMotion, bool& slewed) const {
    const double square = glm::dot(byMotion, byMotion);
    const double share =
        square > 0.0 ? std::clamp(glm::dot(wanted - sent, byMotion) / square, 0.0, 1.0) : 0.0;
    const glm::dvec3 base = sent + share * byMotion;
    return base + clampLength(wanted - base, step, slewed);
  }
};

std::array<double, 10> settingsOf(const TickParameters& p) {
  return {p.toolRadius,        p.stiffness,       p.damping,    p.graspStiffness, p.graspDamping,
          p.graspRotStiffness, p.graspRotDamping, p.forceLimit, p.torqueLimit,    p.gain};
}

/// Damping for what the sampling of the force has created, and the sum within the limit.
glm::dvec3 withPassivity(const glm::dvec3& force, const glm::dvec3& byTime, const DeviceSample& device,
                         const TickParameters& parameters, PassivityController& controller,
                         std::uint32_t& flags) {
  bool limited = false;
  const glm::dvec3 added = controller.step(device.worldFromDevice.position, force, byTime,
                                           parameters.deviceDamping, parameters.dt);
  if (added != glm::dvec3(0.0)) flags |= kFlagPassivity;
  const glm::dvec3 sent = clampLength(force + added, parameters.forceLimit, limited);
  controller.sent(sent);
  return sent;
}

}  // namespace

Wrench limitOutput(const Wrench& wanted, const DeviceSample* device, const ForceCause& cause,
                   const TickParameters& parameters, FaultLatch& fault, OutputLimits& limits,
                   std::uint32_t& flags) {
  const bool good = TICK_ASSERT(fault, isFinite(wanted.force) && isFinite(wanted.torque));
  if (fault.raised()) flags |= kFlagFault;
  const std::array<double, 10> settings = settingsOf(parameters);
  const bool ordered = limits.silent || fault.raised() || settings != limits.settings;
  limits.settings = settings;
  // No actuator may be driven on a reading that is not there, nor once the user has hit the key.
  limits.silent = device == nullptr || parameters.zeroForce;
  if (limits.silent) {
    limits.sent = limits.within = Wrench{};
    limits.passivity.restart();
    return {};
  }
  bool limited = false, slewed = false;
  const double gain = fault.raised() || !good ? 0.0 : std::clamp(parameters.gain, 0.0, 1.0);
  const Wrench within = gain > 0.0
                            ? Wrench{clampLength(wanted.force * gain, parameters.forceLimit, limited),
                                     clampLength(wanted.torque * gain, parameters.torqueLimit, limited)}
                            : Wrench{};
  const double torqueStep = parameters.torqueSlewLimit * parameters.dt;
  const bool foreign = parameters.foreignSlewLimit > 0.0 && !ordered && (!cause.byHand || limits.foreign);
  const double step = parameters.dt * (foreign ? std::min(parameters.slewLimit, parameters.foreignSlewLimit)
                                               : parameters.slewLimit);
  const Channel force{limits.sent.force, limits.within.force};
  const Channel torque{limits.sent.torque, limits.within.torque};
  Wrench now;
  if (ordered || !cause.byHand) {
    now.force = force.byOthers(within.force, step + (ordered ? 0.0 : cause.explained),
                               ordered ? glm::dvec3(0.0) : cause.byMotion, slewed);
  } else {
    now.force = force.byHand(within.force, step, slewed);
  }
  limits.foreign = foreign && slewed;
  now.torque = ordered ? torque.byOthers(within.torque, torqueStep, glm::dvec3(0.0), slewed)
                       : torque.byHand(within.torque, torqueStep, slewed);
  if (parameters.deviceSlewLimit > 0.0) {
    const double deviceStep = parameters.deviceSlewLimit * parameters.dt;
    now.force = limits.sent.force + clampLength(now.force - limits.sent.force, deviceStep, slewed);
  }
  limits.within = within;
  limits.sent = now;
  if (limited) flags |= kFlagForceLimited;
  if (slewed) flags |= kFlagSlewLimited;
  if (parameters.passivity) {
    const double wantedForce = glm::length(wanted.force);
    const double share = wantedForce > 0.0 ? std::min(glm::length(within.force) / wantedForce, 1.0) : gain;
    now.force = withPassivity(now.force, cause.byTime * share, *device, parameters, limits.passivity, flags);
  }
  return now;
}

}  // namespace tandem::haptics
