#pragma once

#include <string>

namespace tandem::client::report {

/// A temporary folder that caches fields while settings with the same fields are measured. The destructor
/// removes it.
class FieldFolder {
 public:
  FieldFolder();
  ~FieldFolder();
  FieldFolder(const FieldFolder&) = delete;
  FieldFolder& operator=(const FieldFolder&) = delete;

  /// Empty if no folder can be made; then every field is made anew.
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

}  // namespace tandem::client::report
