#pragma once

#include <string>

namespace tandem::assets {

/// A folder of its own among the temporary files. The destructor removes it with what is in it.
class TemporaryFolder {
 public:
  /// `prefix`: of its name.
  explicit TemporaryFolder(const std::string& prefix);
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  /// Empty if no folder can be made.
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

}  // namespace tandem::assets
