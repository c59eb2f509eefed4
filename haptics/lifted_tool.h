#pragma once

// A tool that is lifted off the scene, as while the window draws parts elsewhere than they are: it touches
// nothing, no field acts on it, and neither lifting it nor setting it down kicks the hand.

#include "haptics/tick_data.h"

namespace tandem::haptics {

/// The tool goes with the hand, off everything. What it felt fades as gently as where sections take it away.
/// `spring`: N/m, of the contacts.
void liftTool(double spring, TickState::Data& data);
/// A tool that was lifted begins anew where its device is, and passes through what it is inside of until it
/// has left that.
void setToolDown(TickState::Data& data);
/// The part under the tool; none while it is lifted.
PartId partTouched(const TickOutput& out, TickState::Data& data);
/// The share, 0..1, with which fields act on the tip in this tick.
double setDownShare(bool lifted, const TickParameters& parameters, TickState::Data& data);

}  // namespace tandem::haptics
