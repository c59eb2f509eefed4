#pragma once

// What acts on the parts in the hands beside contact: force fields, magnets and touched surfaces. A part in
// both hands is felt by the first one.

#include "haptics/tick_data.h"

namespace tandem::haptics {

FieldSettings fieldSettings(const TickParameters& parameters, PartId held);

/// What fields do to the parts in the hands, in their next step; `now` s, by the clock of the session.
void pullByFields(double now, int hands, const TickParameters& parameters, TickState::Data& data,
                  TickOutput& out);

/// What magnets do to them, and they to magnets that move here.
void pullByMagnets(int hands, const TickParameters& parameters, TickState::Data& data, TickOutput& out);

/// What the surfaces under them add, after they have moved.
void feelSurfacesThroughParts(int hands, TickState::Data& data, TickOutput& out);

}  // namespace tandem::haptics
