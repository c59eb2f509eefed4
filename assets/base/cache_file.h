#pragma once

// Files of a cache. A reader sees a file whole or not at all. A file that cannot be read or written costs
// only the time to derive its content again, so failures are not reported.

#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
#include <vector>

namespace tandem::assets {

/// The whole content of a file; nothing if it does not exist or cannot be read.
std::optional<std::vector<std::byte>> readCacheFile(const std::filesystem::path& path);

/// Writes a temporary file and renames it. Makes the directory if it does not exist.
void writeCacheFile(const std::filesystem::path& path, std::span<const std::byte> content);

}  // namespace tandem::assets
