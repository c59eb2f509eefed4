#include "client/join/scene_store.h"

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>

#include "assets/base/assert.h"

namespace tandem::client {

namespace fs = std::filesystem;

namespace {

std::vector<std::byte> readFile(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::vector<char> bytes((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  const auto* begin = reinterpret_cast<const std::byte*>(bytes.data());
  return {begin, begin + bytes.size()};
}

/// Writes another file and renames it, so that a reader sees the whole file or none.
void writeFileWhole(const std::string& path, const std::vector<std::byte>& bytes) {
  std::error_code ignored;
  fs::create_directories(fs::path(path).parent_path(), ignored);
  const std::string beside = path + "." + std::to_string(::getpid());
  std::ofstream file(beside, std::ios::binary);
  file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  file.close();
  if (file) fs::rename(beside, path, ignored);
  fs::remove(beside, ignored);
}

}  // namespace

std::string SceneStore::path(const assets::ContentHash& hash, const char* ending) const {
  return directory_ + "/received/" + assets::toHex(hash) + ending;
}

std::vector<std::byte> SceneStore::find(const assets::ContentHash& hash) const {
  if (directory_.empty()) return {};
  std::vector<std::byte> package = readFile(path(hash, ".scene"));
  return !package.empty() && assets::contentHash(package) == hash ? package : std::vector<std::byte>{};
}

std::vector<std::byte> SceneStore::beginning(const assets::ContentHash& hash) const {
  return directory_.empty() ? std::vector<std::byte>{} : readFile(path(hash, ".part"));
}

void SceneStore::keep(const assets::ContentHash& hash, const std::vector<std::byte>& package) const {
  ASSERT(!package.empty());
  if (directory_.empty()) return;
  writeFileWhole(path(hash, ".scene"), package);
  forgetBeginning(hash);
}

void SceneStore::forgetBeginning(const assets::ContentHash& hash) const {
  std::error_code ignored;
  if (!directory_.empty()) fs::remove(path(hash, ".part"), ignored);
}

void SceneStore::keepBeginning(const assets::ContentHash& hash, const std::vector<std::byte>& bytes) const {
  if (!directory_.empty() && !bytes.empty()) writeFileWhole(path(hash, ".part"), bytes);
}

}  // namespace tandem::client
