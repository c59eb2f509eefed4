#pragma once

// Identifiers that all folders share. They are numbers and not pointers, because they travel over the wire.

#include <cstddef>
#include <cstdint>

namespace tandem {

/// Index of a part in Scene::parts; the same at every site, since all sites hold the same scene package.
using PartId = std::uint16_t;
inline constexpr PartId kNoPart = 0xffff;
inline constexpr std::size_t kMaxParts = 16384;

/// A participant of a session. The server assigns it, and never twice within one data directory.
using SiteId = std::uint16_t;
inline constexpr SiteId kNoSite = 0;

/// Number of ownerships of one part so far. It grows with every grant, also across server restarts (S1).
using Epoch = std::uint32_t;

}  // namespace tandem
