#pragma once

// Any state message. State messages may be lost, doubled or reordered on their way.

#include <variant>

#include "sync/wire/clock_messages.h"
#include "sync/wire/link_update.h"
#include "sync/wire/state_update.h"

namespace tandem::sync {

using StateMessage = std::variant<StateUpdate, Ping, Pong, LinkUpdate, StateAck>;

}  // namespace tandem::sync
