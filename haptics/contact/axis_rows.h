#pragma once

// The rows of controls among the bodies of an island: a control moves along or about its one axis, between
// its stops and against its dry friction.
//
// Across the axis the inertia of its step holds it (guidedStep() in virtual_coupling.h), so no row is needed
// for that.

#include "haptics/contact/contact_island.h"
#include "haptics/solver/contact_rows.h"

namespace tandem::haptics {

/// Adds the rows of all pairs of kind ContactPair::kAxis to those of a step within a tick of dt seconds.
void addAxisRows(const ContactIsland& island, double dt, ContactRows& rows);

}  // namespace tandem::haptics
