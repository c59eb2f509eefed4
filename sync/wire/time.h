#pragma once

#include <cstdint>

namespace tandem::sync {

/// Microseconds. Session time is the server's clock, counted from the start of the session's data directory
/// and never running backwards, also across restarts; every site estimates it (sync/replica/clock_offset.h).
/// Local time is a site's own monotonic clock.
using Micros = std::int64_t;

inline constexpr Micros kMillisecond = 1000;
inline constexpr Micros kSecond = 1000000;

inline constexpr double toSeconds(Micros t) { return static_cast<double>(t) * 1e-6; }

}  // namespace tandem::sync
