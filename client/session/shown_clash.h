#pragma once

// A clash as one person shows it to the others: what was found, on its way to the wire and back.

#include "client/review/clash_check.h"
#include "sync/wire/presentation_messages.h"

namespace tandem::client {

/// Puts a clash into what is looked at; the poses are those at which it was found.
void putClash(const Clash& clash, const Pose& worldFromA, const Pose& worldFromB, sync::Inspection& looks);
/// Kind, depth and distance of the clash that is looked at.
Clash clashIn(const sync::Inspection& looks);

}  // namespace tandem::client
