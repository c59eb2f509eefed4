#pragma once

// Where the bytes of a glTF file come from: memory, or a large file, of which only what is needed is read,
// when it is needed. For the loader's sources only.
//
// 1. A file may be changed by others while it is open. What was read stays as it was read; a read that finds
//    the file too short throws GltfError, and requireUnchanged() tells by size and time of change.
// 2. Any thread may read.

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace tandem::assets {

using Bytes = std::vector<unsigned char>;
using ByteView = std::span<const unsigned char>;

/// Bytes of a source: a view of those in memory, or a copy that ends with this.
class GltfPiece {
 public:
  GltfPiece() = default;
  explicit GltfPiece(ByteView inMemory) : view_(inMemory) {}
  explicit GltfPiece(Bytes copy) : copy_(std::move(copy)), view_(copy_) {}
  GltfPiece(GltfPiece&&) noexcept = default;  // the bytes of a vector stay where they are
  GltfPiece& operator=(GltfPiece&&) noexcept = default;

  ByteView view() const { return view_; }

 private:
  Bytes copy_;
  ByteView view_;
};

class GltfSource {
 public:
  GltfSource() = default;
  explicit GltfSource(Bytes inMemory) : bytes_(std::move(inMemory)), size_(bytes_.size()) {}
  /// A regular file below 2 GiB; `place` stands in messages. Files of up to 1 MiB are read at once, and
  /// larger ones too unless they may be kept open. Throws GltfError.
  GltfSource(const std::string& path, const std::string& place, bool keepOpen = true);

  std::size_t size() const { return size_; }
  /// 0 <= at, at + count <= size(). The piece must not outlive this.
  GltfPiece read(std::size_t at, std::size_t count) const;
  /// Throws GltfError if the size of the file or the time of its last change is another than when it was
  /// opened. A write of the same length within the resolution of that time stays unnoticed.
  void requireUnchanged() const;

 private:
  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  void readInto(std::span<unsigned char> out, std::size_t at) const;
  [[noreturn]] void refuse(const std::string& why) const;

  Bytes bytes_;  // all of them, unless there is a file
  std::unique_ptr<std::FILE, Close> file_;
  std::size_t size_ = 0;
  std::int64_t changed_ = 0;  // ns, when the file was last changed
  std::string path_, place_;
};

/// A part of a source, which must outlive it.
struct GltfRange {
  const GltfSource* source = nullptr;  // may be null where the size is 0
  std::size_t at = 0, size = 0;

  /// 0 <= offset, offset + count <= size.
  GltfPiece read(std::size_t offset, std::size_t count) const {
    return count > 0 ? source->read(at + offset, count) : GltfPiece();
  }
};

}  // namespace tandem::assets
