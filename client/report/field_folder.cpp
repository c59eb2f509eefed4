#include "client/report/field_folder.h"

#include <stdlib.h>

#include <filesystem>

namespace tandem::client::report {

FieldFolder::FieldFolder()
    : path_((std::filesystem::temp_directory_path() / "tandem-report-XXXXXX").string()) {
  if (::mkdtemp(path_.data()) == nullptr) path_.clear();
}

FieldFolder::~FieldFolder() {
  std::error_code ignored;
  if (!path_.empty()) std::filesystem::remove_all(path_, ignored);
}

}  // namespace tandem::client::report
