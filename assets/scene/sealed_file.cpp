#include "assets/scene/sealed_file.h"

#include <cstring>

#include "assets/base/cache_file.h"

namespace tandem::assets {
namespace {

struct SealedHeader {
  Seal seal;
  ContentHash content{};
};
static_assert(sizeof(SealedHeader) == 8 + 2 * sizeof(ContentHash), "read and written as it lies in memory");

}  // namespace

std::span<const std::byte> SealedContent::bytes() const {
  return std::span<const std::byte>(file_).subspan(sizeof(SealedHeader));
}

std::optional<SealedContent> readSealedFile(const std::filesystem::path& path, const Seal& seal) {
  std::optional<std::vector<std::byte>> file = readCacheFile(path);
  SealedHeader header;
  if (!file || file->size() < sizeof header) return std::nullopt;
  std::memcpy(&header, file->data(), sizeof header);
  SealedContent content(std::move(*file));
  if (header.seal.mark != seal.mark || header.seal.key != seal.key ||
      header.content != contentHash(content.bytes()))
    return std::nullopt;
  return content;
}

void writeSealedFile(const std::filesystem::path& path, const Seal& seal,
                     std::span<const std::byte> content) {
  const SealedHeader header{seal, contentHash(content)};
  std::vector<std::byte> file(sizeof header + content.size());
  std::memcpy(file.data(), &header, sizeof header);
  if (!content.empty()) std::memcpy(file.data() + sizeof header, content.data(), content.size());
  writeCacheFile(path, file);
}

}  // namespace tandem::assets
