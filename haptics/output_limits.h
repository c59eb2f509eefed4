#pragma once

// The last step of a tick: what leaves for the hand is finite, within the device's limits, and does not
// change faster than they allow.

#include "haptics/fault.h"
#include "haptics/tick.h"

namespace tandem::haptics {

/// What the limits remember from one tick to the next.
struct OutputLimits {
  Wrench sent;  // of the last tick: what slew limits are counted from
};

/// The wrench that goes out in place of `wanted`. Without a valid sample, or with the emergency key down, it
/// is zero at once, without a ramp; under a latched fault it ramps to zero. Sets the flags that apply.
Wrench limitOutput(const Wrench& wanted, bool validSample, const TickParameters& parameters,
                   FaultLatch& fault, OutputLimits& limits, std::uint32_t& flags);

}  // namespace tandem::haptics
