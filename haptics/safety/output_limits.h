#pragma once

// The last step of a tick: the wrench on the hand is finite and within the device's limits, and jumps only
// if the hand itself made it jump.
//
// A hand that strokes over an edge at 5 m/s must feel a step of force. A part that is put onto the tool, a
// recovery after silence, a fault or a slider must not kick the hand. So the slew limit applies not to the
// force but to the jump at its cause: in a tick whose change the hand did not make, the excess over the cap
// is held back, and it is released at the capped rate while changes that the hand makes meanwhile pass at
// once. To a hand under a part that jumped onto it this is a surface that arrives at cap / stiffness metres
// a second.
//
// 1. While something is held back, the force lies between zero, the last force sent and the wanted one. It
//    never pulls towards a surface, and on a hand that has left contact nothing remains but what fades at
//    the capped rate.
// 2. A device that cannot follow faster changes has a limit of its own, whatever the cause.

#include <array>

#include "haptics/base/fault.h"
#include "haptics/base/tick_types.h"
#include "haptics/safety/passivity_controller.h"

namespace tandem::haptics {

/// Why the wanted force changed in this tick.
struct ForceCause {
  bool byHand = true;      // nothing but the hand's own motion, and what follows from it
  double explained = 0.0;  // N: of a change that others made, as much as may pass beyond the cap
  glm::dvec3 byMotion{0.0, 0.0,
                      0.0};          // N: what the hand's own motion did to a spring; any share of it passes
  glm::dvec3 byTime{0.0, 0.0, 0.0};  // N: of the change, what force fields gave by their laws as time went on
};

/// What the limits remember from one tick to the next.
struct OutputLimits {
  PassivityController passivity;
  Wrench sent;                        // of the last tick, without what the passivity controller adds
  Wrench within;                      // what would have been sent if nothing were held back
  bool foreign = false;               // what is held back comes from parts that others move
  bool silent = true;                 // no force by order in the last tick: the next one is a recovery
  std::array<double, 10> settings{};  // those whose change makes a force jump
};

/// The wrench that goes out in place of `wanted`. Without a valid sample (null), or with the emergency key
/// down, it is zero at once, without a ramp; under a latched fault it ramps to zero. Sets the flags that
/// apply.
Wrench limitOutput(const Wrench& wanted, const DeviceSample* device, const ForceCause& cause,
                   const TickParameters& parameters, FaultLatch& fault, OutputLimits& limits,
                   std::uint32_t& flags);

}  // namespace tandem::haptics
