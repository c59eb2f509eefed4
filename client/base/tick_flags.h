#pragma once

// The names of the flags of a tick, for reports.

#include <cstdint>
#include <span>

namespace tandem::client {

struct TickFlagName {
  std::uint32_t flag;  // of haptics::TickFlag
  const char* name;
};

std::span<const TickFlagName> tickFlagNames();

}  // namespace tandem::client
