#include "assets/base/temporary_folder.h"

#include <stdlib.h>

#include <filesystem>
#include <system_error>

namespace tandem::assets {

TemporaryFolder::TemporaryFolder(const std::string& prefix) {
  std::error_code failed;
  std::string pattern = std::filesystem::temp_directory_path(failed) / (prefix + "XXXXXX");
  if (!failed && ::mkdtemp(pattern.data()) != nullptr) path_ = pattern;
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  if (!path_.empty()) std::filesystem::remove_all(path_, ignored);
}

}  // namespace tandem::assets
