#pragma once

// Scene files of every kind: glTF as it is, and CAD files, of which tandem-import, a program of its own,
// makes glTF first, in a process with limits. No program is linked with what reads CAD.

#include <functional>
#include <string>

#include "assets/base/result.h"
#include "assets/gltf/load_gltf.h"

namespace tandem::assets {

/// Whether the name ends like a CAD file that tandem-import reads.
bool isCadFile(const std::string& path);

/// A scene file, and what a user states about where its result is kept and which unit it has.
struct SceneFile {
  std::string path;
  std::string units = "m";     // m, which a scene has unless stated, leaves a CAD file its own
  std::string cacheDirectory;  // of imports and of prepared scenes; empty: neither is kept
};

/// loadScene(), with `options.unitScale` as the file's unit, after the import of a CAD file, which is kept
/// under the hash of the file and its unit. The share done of the import and of loading each go from 0 to 1.
/// The import ends where `cancelled` returns true. An error has the file's name and the reason.
Result<Scene> loadSceneFile(const SceneFile& file, LoadOptions options,
                            const std::function<bool()>& cancelled = {});

}  // namespace tandem::assets
