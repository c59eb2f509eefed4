#pragma once

// Cache files that say what they were made of, and whether they are whole: a mark of the kind of file, the
// hash of what it was made of, the hash of its content, the content.

#include <array>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "assets/scene/scene_package.h"

namespace tandem::assets {

/// What a file is: its kind, and the hash of all that its content follows from.
struct Seal {
  std::array<char, 8> mark{};
  ContentHash key{};
};

/// The content of an intact file.
class SealedContent {
 public:
  explicit SealedContent(std::vector<std::byte> file) : file_(std::move(file)) {}
  std::span<const std::byte> bytes() const;

 private:
  std::vector<std::byte> file_;
};

/// Nothing unless the file has this seal and holds what was written.
std::optional<SealedContent> readSealedFile(const std::filesystem::path& path, const Seal& seal);

/// As writeCacheFile().
void writeSealedFile(const std::filesystem::path& path, const Seal& seal, std::span<const std::byte> content);

}  // namespace tandem::assets
