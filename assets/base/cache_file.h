#pragma once

// Files of a cache: read whole, and never seen half written. What cannot be read or written costs time only, so
// that failures pass in silence.

#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
#include <vector>

namespace tandem::assets {

/// All of a file; nothing if there is none or it cannot be read.
std::optional<std::vector<std::byte>> readCacheFile(const std::filesystem::path& path);

/// Writes under a name of its own, then renames; makes the directory where it is missing.
void writeCacheFile(const std::filesystem::path& path, std::span<const std::byte> content);

}  // namespace tandem::assets
