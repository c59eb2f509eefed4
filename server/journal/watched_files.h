#pragma once

// Files that must stay what they were: a path that leads to another file, or to none, is noticed. It only
// asks for their status, because closing a file drops the locks that SQLite holds on it.

#include <string>
#include <vector>

#include "assets/base/result.h"

namespace tandem::server {

class WatchedFiles {
 public:
  /// Takes a file as it is now. Errors name it.
  Status add(const std::string& path);
  /// Which file was removed or replaced.
  Status check() const;

 private:
  struct File {
    std::string path;
    std::uint64_t device = 0, inode = 0;
  };
  std::vector<File> files_;
};

}  // namespace tandem::server
