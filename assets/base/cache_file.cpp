#include "assets/base/cache_file.h"

#include <fstream>
#include <random>
#include <string>
#include <system_error>

namespace tandem::assets {

std::optional<std::vector<std::byte>> readCacheFile(const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) return std::nullopt;
  std::ifstream in(path, std::ios::binary);
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  if (!in || error) return std::nullopt;
  std::vector<std::byte> content(static_cast<std::size_t>(size));
  in.read(reinterpret_cast<char*>(content.data()), static_cast<std::streamsize>(content.size()));
  if (!in) return std::nullopt;
  return content;
}

void writeCacheFile(const std::filesystem::path& path, std::span<const std::byte> content) {
  std::error_code error;
  std::filesystem::create_directories(path.parent_path(), error);
  std::random_device random;
  std::filesystem::path temporary = path;
  temporary += ".tmp" + std::to_string(random());
  {
    std::ofstream out(temporary, std::ios::binary);
    out.write(reinterpret_cast<const char*>(content.data()), static_cast<std::streamsize>(content.size()));
    out.close();
    if (!out) {
      std::filesystem::remove(temporary, error);
      return;
    }
  }
  std::filesystem::rename(temporary, path, error);
  if (error) std::filesystem::remove(temporary, error);
}

}  // namespace tandem::assets
