#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <optional>

#include "assets/base/cache_file.h"
#include "assets/gltf/gltf_loader.h"
#include "assets/scene/scene_package.h"

namespace tandem::assets {
namespace {

// Raised whenever the loader's result for the same file changes.
constexpr std::uint32_t kLoaderVersion = 11;
constexpr std::size_t kHashedAtOnce = 1 << 20;

/// Hash of everything that the scene depends on.
class KeyBuilder {
 public:
  template <typename T>
  void number(T value) {
    const auto* bytes = reinterpret_cast<const std::byte*>(&value);
    bytes_.insert(bytes_.end(), bytes, bytes + sizeof value);
  }
  void text(const std::string& value) {
    number(std::uint64_t(value.size()));
    const auto* bytes = reinterpret_cast<const std::byte*>(value.data());
    bytes_.insert(bytes_.end(), bytes, bytes + value.size());
  }
  void content(const GltfSource& source) {
    number(std::uint64_t(source.size()));
    GltfPiece piece;
    std::size_t at = 0;
    const auto next = [&] {
      const std::size_t count = std::min(kHashedAtOnce, source.size() - at);
      piece = source.read(at, count);
      at += count;
      return std::as_bytes(piece.view());
    };
    for (const std::uint8_t byte : hashOfPieces(next)) number(byte);
  }
  std::string name() const { return toHex(contentHash(bytes_)); }

 private:
  std::vector<std::byte> bytes_;
};

std::string cacheKey(const std::string& name, const GltfDocument& document, const LoadOptions& options) {
  KeyBuilder key;
  key.number(kLoaderVersion);
  key.text(name);
  key.number(options.unitScale);
  key.number(options.allMovable);
  key.number(std::uint64_t(options.movable.size()));
  for (const std::string& part : options.movable) key.text(part);
  key.number(options.density);
  key.number(options.creaseAngle);
  key.number(options.normals);
  key.number(options.gravity.x);
  key.number(options.gravity.y);
  key.number(options.gravity.z);
  key.number(std::uint64_t(options.maxTriangles));
  key.content(document.file);
  for (const GltfSource* external : document.externals) key.content(*external);
  return key.name();
}

}  // namespace

Result<Scene> loadScene(const std::string& path, const LoadOptions& options,
                        const std::string& cacheDirectory) {
  if (cacheDirectory.empty()) return loadGltf(path, options);
  try {
    std::optional<GltfDocument> document(std::in_place);
    openFromDisk(path, options, *document);
    const std::string name = std::filesystem::path(path).filename().string();
    const std::filesystem::path cached =
        std::filesystem::path(cacheDirectory) / (cacheKey(name, *document, options) + ".scene");
    if (const std::optional<std::vector<std::byte>> package = readCacheFile(cached)) {
      document.reset();  // a large file need not lie beside its scene
      if (Result<Scene> scene = unpackScene(*package)) {
        if (options.progress) options.progress(1.0, "read from the cache");
        return scene;
      }
      openFromDisk(path, options, document.emplace());
    }
    Scene scene = buildScene(name, *document, options);
    document.reset();
    writeCacheFile(cached, packScene(scene));
    return scene;
  } catch (...) {
    return describeError(path);
  }
}

std::string defaultCacheDirectory() {
  const char* cache = std::getenv("XDG_CACHE_HOME");
  if (cache != nullptr && *cache != '\0') return std::string(cache) + "/tandem";
  const char* home = std::getenv("HOME");
  if (home != nullptr && *home != '\0') return std::string(home) + "/.cache/tandem";
  return "";
}

}  // namespace tandem::assets
