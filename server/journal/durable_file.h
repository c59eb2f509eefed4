#pragma once

// Small files that are on the disk whole or not at all.

#include <optional>
#include <string>

#include "assets/base/result.h"

namespace tandem::server {

/// The content of a file of at most 64 KiB; nothing if there is no such file. Links are not followed.
Result<std::optional<std::string>> readSmallFile(const std::string& path);
/// Writes a file with mode 0600: it is synced under another name, renamed, and its directory synced.
Status writeDurably(const std::string& path, const std::string& content);
/// Syncs the directory that a file lies in, so that its name is safe.
Status syncDirectoryOf(const std::string& path);

}  // namespace tandem::server
