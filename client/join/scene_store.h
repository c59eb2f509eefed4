#pragma once

// Scene packages that this user's sites have fetched: whole ones by content hash, and the beginnings of
// interrupted transfers.

#include <cstddef>
#include <string>
#include <vector>

#include "assets/base/result.h"
#include "assets/scene/scene_package.h"

namespace tandem::client {

class SceneStore {
 public:
  /// Empty directory: nothing is kept.
  explicit SceneStore(std::string directory) : directory_(std::move(directory)) {}

  /// The package with this hash; empty if there is none, or if the file is damaged.
  std::vector<std::byte> find(const assets::ContentHash& hash) const;
  /// The bytes of an earlier, interrupted transfer of this package.
  std::vector<std::byte> beginning(const assets::ContentHash& hash) const;
  /// Keeps a whole package (removing its beginning), or a beginning. A store that cannot be written is no
  /// error: the next visit transfers again.
  void keep(const assets::ContentHash& hash, const std::vector<std::byte>& package) const;
  void keepBeginning(const assets::ContentHash& hash, const std::vector<std::byte>& bytes) const;
  void forgetBeginning(const assets::ContentHash& hash) const;

 private:
  std::string path(const assets::ContentHash& hash, const char* ending) const;
  std::string directory_;
};

}  // namespace tandem::client
