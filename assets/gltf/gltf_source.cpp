#include "assets/gltf/gltf_source.h"

#include <cerrno>
#include <filesystem>
#include <limits>
#include <system_error>

#include <sys/stat.h>
#include <unistd.h>

#include "assets/base/assert.h"
#include "assets/gltf/gltf_error.h"

namespace tandem::assets {
namespace {

constexpr std::uintmax_t kMaxFileBytes = std::numeric_limits<std::int32_t>::max();
constexpr std::size_t kReadAtOnce = 1 << 20;

std::int64_t changeTime(const struct stat& status) {
  return std::int64_t{status.st_mtim.tv_sec} * 1'000'000'000 + status.st_mtim.tv_nsec;
}

}  // namespace

GltfSource::GltfSource(const std::string& path, const std::string& place, bool keepOpen)
    : path_(path), place_(place) {
  std::error_code error;
  const auto kind = std::filesystem::status(path, error);
  if (!std::filesystem::exists(kind)) refuse("does not exist");
  if (!std::filesystem::is_regular_file(kind)) refuse("is not a regular file");
  file_.reset(std::fopen(path.c_str(), "rb"));
  struct stat status {};
  if (file_ == nullptr || ::fstat(::fileno(file_.get()), &status) != 0)
    refuse("cannot be read: " + std::generic_category().message(errno));
  if (static_cast<std::uintmax_t>(status.st_size) > kMaxFileBytes) refuse("is larger than 2 GiB");
  size_ = static_cast<std::size_t>(status.st_size);
  changed_ = changeTime(status);
  if (keepOpen && size_ > kReadAtOnce) return;
  readInto(bytes_ = Bytes(size_), 0);
  file_.reset();
}

GltfPiece GltfSource::read(std::size_t at, std::size_t count) const {
  ASSERT(at <= size_ && count <= size_ - at);
  if (file_ == nullptr) return GltfPiece(ByteView(bytes_).subspan(at, count));
  Bytes copy(count);
  readInto(copy, at);
  return GltfPiece(std::move(copy));
}

void GltfSource::readInto(std::span<unsigned char> out, std::size_t at) const {
  for (std::size_t done = 0; done < out.size();) {
    const ssize_t got =
        ::pread(::fileno(file_.get()), out.data() + done, out.size() - done, static_cast<off_t>(at + done));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) refuse("cannot be read: " + std::generic_category().message(errno));
    if (got == 0) refuse("has become shorter while it was read");
    done += static_cast<std::size_t>(got);
  }
}

void GltfSource::requireUnchanged() const {
  if (file_ == nullptr) return;
  struct stat status {};
  if (::fstat(::fileno(file_.get()), &status) != 0 || static_cast<std::size_t>(status.st_size) != size_ ||
      changeTime(status) != changed_)
    refuse("has changed while it was read");
}

void GltfSource::refuse(const std::string& why) const { throw GltfError(place_, "'" + path_ + "' " + why); }

}  // namespace tandem::assets
