#pragma once

// The names of what a tick may have to say, for reports.

#include <cstdint>
#include <span>

namespace tandem::client {

struct TickFlagName {
  std::uint32_t flag;  // of haptics::TickFlag
  const char* name;
};

std::span<const TickFlagName> tickFlagNames();

}  // namespace tandem::client
