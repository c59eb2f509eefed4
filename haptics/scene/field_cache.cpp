#include "haptics/scene/field_cache.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <optional>
#include <utility>
#include <vector>

#include "assets/scene/sealed_file.h"
#include "haptics/geometry/triangle_bvh.h"

namespace tandem::haptics {
namespace {

// Raised whenever a bake of the same mesh and options produces another result.
constexpr std::uint64_t kBakeVersion = 8;

constexpr std::array<char, 8> kCacheMark = {'T', 'D', 'F', 'C', 'a', 'c', 'h', 'e'};

template <typename T>
void append(std::vector<std::byte>& bytes, const T* values, std::size_t count) {
  const auto* begin = reinterpret_cast<const std::byte*>(values);
  bytes.insert(bytes.end(), begin, begin + count * sizeof(T));
}

/// The field depends on positions and triangles alone, not on the mesh's topology data.
assets::ContentHash keyOf(const assets::Mesh& mesh, const DistanceField::Options& options) {
  std::vector<std::byte> bytes;
  const std::array<std::uint64_t, 4> counts = {kBakeVersion, mesh.positions.size(), mesh.triangles.size(),
                                               options.memory};
  const std::array<double, 3> lengths = {options.tolerance, options.smallestCell, options.band};
  bytes.reserve(sizeof counts + sizeof lengths + mesh.positions.size() * sizeof(glm::dvec3) +
                mesh.triangles.size() * sizeof(mesh.triangles[0]));
  append(bytes, counts.data(), counts.size());
  append(bytes, lengths.data(), lengths.size());
  append(bytes, mesh.positions.data(), mesh.positions.size());
  append(bytes, mesh.triangles.data(), mesh.triangles.size());
  return assets::contentHash(bytes);
}

std::optional<DistanceField> read(const std::filesystem::path& path, const assets::ContentHash& key,
                                  std::size_t triangles) {
  const std::optional<assets::SealedContent> content = assets::readSealedFile(path, {kCacheMark, key});
  if (!content) return std::nullopt;
  Result<DistanceField> field = DistanceField::unpack(content->bytes(), triangles);
  if (!field) return std::nullopt;
  return std::move(field).value();
}

std::filesystem::path pathOf(const std::string& directory, const assets::ContentHash& key) {
  return std::filesystem::path(directory) / (assets::toHex(key) + ".field");
}

}  // namespace

DistanceField cachedField(const TriangleBvh& tree, const DistanceField::Options& options,
                          const std::string& directory, bool& cached) {
  cached = false;
  if (directory.empty()) return DistanceField(tree, options);
  const assets::ContentHash key = keyOf(tree.mesh(), options);
  const std::filesystem::path path = pathOf(directory, key);
  if (std::optional<DistanceField> field = read(path, key, tree.mesh().triangles.size())) {
    cached = true;
    if (options.progress) options.progress(1.0);
    return std::move(*field);
  }
  DistanceField field(tree, options);
  if (!field.stopped()) assets::writeSealedFile(path, {kCacheMark, key}, field.pack());
  return field;
}

std::optional<DistanceField> readField(const TriangleBvh& tree, const DistanceField::Options& options,
                                       const std::string& directory) {
  if (directory.empty()) return std::nullopt;
  const assets::ContentHash key = keyOf(tree.mesh(), options);
  return read(pathOf(directory, key), key, tree.mesh().triangles.size());
}

}  // namespace tandem::haptics
