#include "server/journal/watched_files.h"

#include <fcntl.h>
#include <sys/stat.h>

#include <cerrno>
#include <cstring>

namespace tandem::server {
namespace {

/// Which file a path leads to. Times are not asked for: a file whose times were read must write them with its
/// next change, which is an access to the disk of its own.
bool identify(const std::string& path, struct statx& found) {
  return ::statx(AT_FDCWD, path.c_str(), AT_STATX_DONT_SYNC, STATX_TYPE | STATX_INO, &found) == 0;
}

std::uint64_t deviceOf(const struct statx& file) {
  return (std::uint64_t{file.stx_dev_major} << 32) | file.stx_dev_minor;
}

}  // namespace

Status WatchedFiles::add(const std::string& path) {
  struct statx now {};
  if (!identify(path, now)) return Error{path + ": " + std::strerror(errno)};
  files_.push_back({path, deviceOf(now), now.stx_ino});
  return {};
}

Status WatchedFiles::check() const {
  for (const File& file : files_) {
    struct statx now {};
    if (!identify(file.path, now))
      return Error{file.path + ": removed under the running server (" + std::strerror(errno) + ")"};
    if (deviceOf(now) != file.device || now.stx_ino != file.inode)
      return Error{file.path + ": replaced under the running server"};
  }
  return {};
}

}  // namespace tandem::server
