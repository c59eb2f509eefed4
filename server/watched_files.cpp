#include "server/watched_files.h"

#include <sys/stat.h>

#include <cerrno>
#include <cstring>

namespace tandem::server {

Status WatchedFiles::add(const std::string& path) {
  struct stat now {};
  if (::stat(path.c_str(), &now) != 0) return Error{path + ": " + std::strerror(errno)};
  files_.push_back({path, now.st_dev, now.st_ino});
  return {};
}

Status WatchedFiles::check() const {
  for (const File& file : files_) {
    struct stat now {};
    if (::stat(file.path.c_str(), &now) != 0)
      return Error{file.path + ": removed under the running server (" + std::strerror(errno) + ")"};
    if (now.st_dev != file.device || now.st_ino != file.inode)
      return Error{file.path + ": replaced under the running server"};
  }
  return {};
}

}  // namespace tandem::server
