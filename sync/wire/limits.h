#pragma once

// Versions of the protocol, and the bounds of its messages. A message outside a bound is refused.

#include <cstddef>
#include <cstdint>

#include "sync/wire/time.h"

namespace tandem::sync {

inline constexpr std::uint16_t kProtocolVersion = 14;  // of a connection
inline constexpr std::uint8_t kStateVersion = 2;       // of a datagram by itself, on a wire or in a recording

inline constexpr std::size_t kMaxNameLength = 64;         // bytes, UTF-8
inline constexpr std::size_t kMaxTextLength = 512;        // bytes, UTF-8: reasons
inline constexpr std::size_t kMaxSayLength = 280;         // bytes, UTF-8
inline constexpr std::size_t kMaxSaidParts = 8;           // links in one message
inline constexpr std::size_t kMaxSaidLines = 200;         // of what was said, that are kept
inline constexpr std::size_t kMaxCredentialLength = 512;  // bytes, ASCII
inline constexpr std::size_t kMaxStateBytes = 1200;       // a whole datagram
inline constexpr std::size_t kMaxChunkBytes = 64 * 1024;
inline constexpr std::size_t kMaxChunkEntries = 1024;  // in one DocumentChunk
// A Welcome with kMaxSites sites and kMaxParts records fits.
inline constexpr std::size_t kMaxControlBytes = (1 << 20) + (1 << 17);
// A control message from a site to the server. The largest is a PutEntry.
inline constexpr std::size_t kMaxRequestBytes = 16 * 1024;
inline constexpr std::size_t kMaxSites = 1024;               // that a session lists at a time
inline constexpr std::size_t kMaxCoHolders = 64;             // of one part, its owner aside
inline constexpr std::size_t kMaxStateParts = 255;           // in one StateUpdate; fewer fit as a rule
inline constexpr std::int64_t kMaxUnixTime = 253402300799;   // s: the end of the year 9999
inline constexpr Micros kMaxMicros = (Micros{1} << 55) - 1;  // +- 1141 years: sums of a few never overflow

}  // namespace tandem::sync
