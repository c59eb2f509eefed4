#include "client/base/tick_flags.h"

#include "haptics/tick.h"

namespace tandem::client {
namespace {

constexpr TickFlagName kNames[] = {{haptics::kFlagInvalidSample, "invalid_sample"},
                                   {haptics::kFlagForceLimited, "force_limited"},
                                   {haptics::kFlagSlewLimited, "slew_limited"},
                                   {haptics::kFlagOverflow, "overflow"},
                                   {haptics::kFlagFault, "fault"},
                                   {haptics::kFlagSqueezed, "squeezed"},
                                   {haptics::kFlagHeldWithoutContact, "held_without_contact"},
                                   {haptics::kFlagProxyReset, "proxy_reset"},
                                   {haptics::kFlagStaleSample, "stale_sample"},
                                   {haptics::kFlagSampleJump, "sample_jump"},
                                   {haptics::kFlagPassivity, "passivity_control"},
                                   {haptics::kFlagPopThrough, "pop_through"},
                                   {haptics::kFlagFieldLimited, "field_limited"},
                                   {haptics::kFlagLessEffort, "less_effort"},
                                   {haptics::kFlagInside, "inside_part"}};

}  // namespace

std::span<const TickFlagName> tickFlagNames() { return kNames; }

}  // namespace tandem::client
