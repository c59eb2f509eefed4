#pragma once

// Scenes that are CAD files: tandem-import, a program of its own, makes glTF of them first.

#include <functional>
#include <string>

#include "assets/base/result.h"

namespace tandem::server {

/// Whether the name ends like a CAD file that tandem-import reads.
bool isCadFile(const std::string& path);

/// Where the glTF scene of a CAD file is, made now or by an earlier run: in `cacheDirectory` under the hash
/// of the file and its unit, or beside `fallback` without a cache. `units` is empty where the file's own
/// counts. `progress` is called with the share done, 0..1; the import ends where `cancelled` returns true.
/// The error has the file's name and the reason.
Result<std::string> importCadFile(const std::string& path, const std::string& units,
                                  const std::string& cacheDirectory, const std::string& fallback,
                                  const std::function<void(double)>& progress,
                                  const std::function<bool()>& cancelled);

}  // namespace tandem::server
