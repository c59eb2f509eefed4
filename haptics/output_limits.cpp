#include "haptics/output_limits.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

namespace tandem::haptics {
namespace {

bool isFinite(const glm::dvec3& v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }

glm::dvec3 clampLength(const glm::dvec3& v, double limit, bool& clamped) {
  const double length = glm::length(v);
  if (length <= limit) return v;
  clamped = true;
  return v * (std::max(limit, 0.0) / length);
}

}  // namespace

Wrench limitOutput(const Wrench& wanted, bool validSample, const TickParameters& parameters,
                   FaultLatch& fault, OutputLimits& limits, std::uint32_t& flags) {
  const bool good = TICK_ASSERT(fault, isFinite(wanted.force) && isFinite(wanted.torque));
  if (fault.raised()) flags |= kFlagFault;
  // No actuator may be driven on a reading that is not there, nor once the user has hit the key.
  if (!validSample || parameters.zeroForce) {
    limits.sent = Wrench{};
    return {};
  }
  bool limited = false, slewed = false;
  const double gain = fault.raised() || !good ? 0.0 : std::clamp(parameters.gain, 0.0, 1.0);
  const Wrench within = gain > 0.0
                            ? Wrench{clampLength(wanted.force * gain, parameters.forceLimit, limited),
                                     clampLength(wanted.torque * gain, parameters.torqueLimit, limited)}
                            : Wrench{};
  const double step = parameters.slewLimit * parameters.dt;
  const double torqueStep =
      parameters.forceLimit > 0.0 ? step * parameters.torqueLimit / parameters.forceLimit : 0.0;
  limits.sent.force += clampLength(within.force - limits.sent.force, step, slewed);
  limits.sent.torque += clampLength(within.torque - limits.sent.torque, torqueStep, slewed);
  if (limited) flags |= kFlagForceLimited;
  if (slewed) flags |= kFlagSlewLimited;
  return limits.sent;
}

}  // namespace tandem::haptics
