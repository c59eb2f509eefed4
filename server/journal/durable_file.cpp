#include "server/journal/durable_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <system_error>

namespace tandem::server {
namespace {

constexpr std::size_t kMaxFileBytes = std::size_t{64} * 1024;

Error failed(const std::string& path, int error) {
  return Error{path + ": " + std::generic_category().message(error)};
}

}  // namespace

Result<std::optional<std::string>> readSmallFile(const std::string& path) {
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW);
  if (file < 0 && errno == ENOENT) return std::optional<std::string>();
  if (file < 0) return failed(path, errno);
  std::string content(kMaxFileBytes, '\0');
  const ssize_t size = ::read(file, content.data(), content.size());
  const int error = errno;
  ::close(file);
  if (size < 0) return failed(path, error);
  content.resize(static_cast<std::size_t>(size));
  return std::optional<std::string>(std::move(content));
}

Status writeDurably(const std::string& path, const std::string& content) {
  const std::string temporary = path + ".new";
  ::unlink(temporary.c_str());
  const int file = ::open(temporary.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, 0600);
  if (file < 0) return failed(temporary, errno);
  const bool written =
      ::write(file, content.data(), content.size()) == static_cast<ssize_t>(content.size()) &&
      ::fsync(file) == 0;
  const int error = errno;
  ::close(file);
  if (!written) return failed(temporary, error);
  if (::rename(temporary.c_str(), path.c_str()) != 0) return failed(path, errno);
  return syncDirectoryOf(path);
}

Status syncDirectoryOf(const std::string& path) {
  const auto parent = std::filesystem::path(path).parent_path();
  const std::string directory = parent.empty() ? "." : parent.string();
  const int file = ::open(directory.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (file < 0) return failed(directory, errno);
  const bool synced = ::fsync(file) == 0 || errno == EINVAL;  // some file systems cannot sync a directory
  const int error = errno;
  ::close(file);
  return synced ? Status{} : failed(directory, error);
}

}  // namespace tandem::server
