#pragma once

// The names by which all folders speak of the same things. Ids, not pointers: they travel over the wire.

#include <cstddef>
#include <cstdint>

namespace tandem {

/// Index of a part in Scene::parts; the same at every site, since all sites hold the same scene package.
using PartId = std::uint16_t;
inline constexpr PartId kNoPart = 0xffff;
inline constexpr std::size_t kMaxParts = 16384;

/// A participant of a session, given by the server, never used again within the session's data directory.
using SiteId = std::uint16_t;
inline constexpr SiteId kNoSite = 0;

/// Counts the ownerships of one part. Grows with every grant, also across restarts of the server (S1).
using Epoch = std::uint32_t;

}  // namespace tandem
