#pragma once

// Loads glTF files. Everything in a file is hostile until the loader has checked it.

#include <functional>
#include <string>
#include <vector>

#include "assets/base/result.h"
#include "assets/scene/scene.h"

namespace tandem::assets {

/// What a user may state about a file in place of the file itself.
struct LoadOptions {
  double unitScale = 1.0;                   // m per unit of the file
  bool allMovable = false;                  // every part with a mesh becomes movable
  std::vector<std::string> movable;         // parts that become movable, by name
  double density = 2700.0;                  // kg/m^3, for parts that state neither mass nor density
  double creaseAngle = 0.5235987755982988;  // rad; sharper edges are kEdgeSharp
  bool normals = true;                      // the file's normals are read, and felt
  glm::dvec3 gravity{0.0, 0.0, 0.0};        // m/s^2; zero leaves it to the file, which by default has none
  std::size_t maxTriangles = 20'000'000;    // of all distinct meshes; a file with more is refused
  // Of JSON, without what texts (embedded data) have beyond 256 bytes; a file with more is refused. 32 MiB
  // take up to 2 GiB of memory.
  std::size_t maxJsonBytes = 32 << 20;
  /// Called from the loading thread with the share done, 0..1, and what is being done.
  std::function<void(double, const char*)> progress;
};

/// m per unit of "m", "mm", "cm", "inch" or "foot"; for any other name an error that lists these.
Result<double> parseUnits(const std::string& name);

/// Loads a .gltf or .glb file into a scene: geometry welded and analysed, extensions read, every index
/// checked. Parts that cannot be decoded, extensionsRequired that are unknown, and broken references refuse
/// the whole file, with one line that names the file, the place in it and the reason. Uses up to all cores.
Result<Scene> loadGltf(const std::string& path, const LoadOptions& options);

/// The same from memory, for scenes without external buffers (tests, fuzzing). `name` stands in error
/// messages.
Result<Scene> loadGltfFromMemory(const std::string& name, const std::vector<unsigned char>& bytes,
                                 const LoadOptions& options);

/// loadGltf() through a cache: `cacheDirectory` holds the prepared scene under the content hash of the file,
/// its buffers and the options. A damaged cache file is ignored and written anew. An empty directory name
/// turns the cache off.
Result<Scene> loadScene(const std::string& path, const LoadOptions& options,
                        const std::string& cacheDirectory);

/// The user's cache directory: $XDG_CACHE_HOME/tandem or ~/.cache/tandem; empty if neither is known.
std::string defaultCacheDirectory();

}  // namespace tandem::assets
