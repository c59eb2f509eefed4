#include "client/levels/level_file.h"

#include <array>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <span>
#include <type_traits>
#include <utility>

#include "assets/scene/sealed_file.h"

namespace tandem::client {
namespace {

// Raised whenever the levels of the same mesh, or their file, become others.
constexpr std::uint64_t kLevelsVersion = 2;
constexpr std::array<char, 8> kLevelsMark = {'T', 'D', 'L', 'e', 'v', 'e', 'l', 's'};

template <typename T>
void append(std::vector<std::byte>& bytes, const std::vector<T>& values) {
  static_assert(std::is_standard_layout_v<T> && std::is_trivially_destructible_v<T>);
  const std::uint64_t count = values.size();
  const std::size_t at = bytes.size();
  bytes.resize(at + sizeof count + count * sizeof(T));
  std::memcpy(bytes.data() + at, &count, sizeof count);
  if (count > 0) std::memcpy(bytes.data() + at + sizeof count, values.data(), count * sizeof(T));
}

/// Takes values off the front; false if there are not as many as it says.
template <typename T>
bool take(std::span<const std::byte>& bytes, std::vector<T>& values) {
  std::uint64_t count = 0;
  if (bytes.size() < sizeof count) return false;
  std::memcpy(&count, bytes.data(), sizeof count);
  bytes = bytes.subspan(sizeof count);
  if (count > bytes.size() / sizeof(T)) return false;
  values.resize(count);
  if (count > 0) std::memcpy(static_cast<void*>(values.data()), bytes.data(), count * sizeof(T));
  bytes = bytes.subspan(count * sizeof(T));
  return true;
}

std::filesystem::path levelsPath(const std::string& directory, const assets::ContentHash& content) {
  return std::filesystem::path(directory) / (assets::toHex(content) + ".levels");
}

}  // namespace

assets::ContentHash levelContent(const assets::Mesh& mesh) {
  const auto hashOf = [](const auto& values) {
    return assets::contentHash(std::as_bytes(std::span(values)));
  };
  const std::array<assets::ContentHash, 5> all = {hashOf(mesh.positions), hashOf(mesh.triangles),
                                                  hashOf(mesh.triangleMaterial), hashOf(mesh.neighbours),
                                                  hashOf(mesh.edgeFlags)};
  std::vector<std::byte> bytes(sizeof kLevelsVersion + sizeof all);
  std::memcpy(bytes.data(), &kLevelsVersion, sizeof kLevelsVersion);
  std::memcpy(bytes.data() + sizeof kLevelsVersion, all.data(), sizeof all);
  return assets::contentHash(bytes);
}

std::optional<std::vector<Level>> readLevels(const std::string& directory,
                                             const assets::ContentHash& content) {
  if (directory.empty()) return std::nullopt;
  const std::optional<assets::SealedContent> file =
      assets::readSealedFile(levelsPath(directory, content), {kLevelsMark, content});
  if (!file) return std::nullopt;
  std::span<const std::byte> rest = file->bytes();
  std::vector<Level> levels;
  std::vector<double> errors;
  std::vector<std::uint8_t> outward;
  if (!take(rest, errors) || !take(rest, outward) || outward.size() != errors.size()) return std::nullopt;
  for (std::size_t i = 0; i < errors.size(); ++i) {
    Level level;
    level.error = errors[i];
    level.facesOutward = outward[i] != 0;
    RenderMesh& mesh = level.mesh;
    if (!take(rest, mesh.vertices) || !take(rest, mesh.indices) || !take(rest, mesh.ranges) ||
        !take(rest, mesh.clusters) || !take(rest, mesh.featureEdges))
      return std::nullopt;
    levels.push_back(std::move(level));
  }
  return levels;
}

void keepLevels(const std::string& directory, const assets::ContentHash& content,
                const std::vector<Level>& levels) {
  if (directory.empty()) return;
  std::vector<std::byte> bytes;
  std::vector<double> errors;
  std::vector<std::uint8_t> outward;
  for (const Level& level : levels) {
    errors.push_back(level.error);
    outward.push_back(level.facesOutward ? 1 : 0);
  }
  append(bytes, errors);
  append(bytes, outward);
  for (const Level& level : levels) {
    append(bytes, level.mesh.vertices);
    append(bytes, level.mesh.indices);
    append(bytes, level.mesh.ranges);
    append(bytes, level.mesh.clusters);
    append(bytes, level.mesh.featureEdges);
  }
  assets::writeSealedFile(levelsPath(directory, content), {kLevelsMark, content}, bytes);
}

}  // namespace tandem::client
