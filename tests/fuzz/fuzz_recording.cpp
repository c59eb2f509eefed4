// A recording that somebody else wrote. The first byte chooses: the rest is the whole file, or it is cut into
// records behind a good header and under good checksums, so that mutations reach the messages inside.

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <span>
#include <string>
#include <vector>

#include "sync/wire/recording.h"

namespace {

using namespace tandem::sync;
using Bytes = std::vector<std::uint8_t>;

/// A file in memory that a path leads to.
class MemoryFile {
 public:
  MemoryFile() : file_(memfd_create("recording", MFD_CLOEXEC)) {
    if (file_ < 0) std::abort();
  }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;
  ~MemoryFile() { close(file_); }
  std::string path() const { return "/proc/self/fd/" + std::to_string(file_); }
  void clear() const {
    if (ftruncate(file_, 0) != 0) std::abort();
  }
  /// Puts the bytes at the end of the file.
  void append(std::span<const std::uint8_t> bytes) const {
    const off_t end = lseek(file_, 0, SEEK_END);
    if (pwrite(file_, bytes.data(), bytes.size(), end) != static_cast<ssize_t>(bytes.size())) std::abort();
  }

 private:
  int file_;
};

/// CRC-32 of IEEE 802.3, bit by bit: slow, and written apart from the reader's.
std::uint32_t crc32(std::span<const std::uint8_t> bytes) {
  std::uint32_t crc = ~0u;
  for (const std::uint8_t byte : bytes) {
    crc ^= byte;
    for (int bit = 0; bit < 8; ++bit) crc = crc >> 1 ^ (crc & 1u ? 0xedb88320u : 0u);
  }
  return ~crc;
}

void putNumber(Bytes& bytes, std::uint64_t value, int size) {
  for (int i = 0; i < size; ++i) bytes.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
}

/// Kind, time and length stand before each payload in the input, one byte each.
Bytes framed(std::span<const std::uint8_t> data) {
  Bytes file;
  while (data.size() >= 3) {
    const std::size_t size = std::min<std::size_t>(data[2], data.size() - 3);
    Bytes record;
    putNumber(record, size, 4);
    putNumber(record, data[0], 1);
    putNumber(record, std::uint64_t{data[1]} << (data[1] % 64u), 8);
    const auto payload = data.subspan(3, size);
    record.insert(record.end(), payload.begin(), payload.end());
    putNumber(record, crc32(record), 4);
    file.insert(file.end(), record.begin(), record.end());
    data = data.subspan(3 + size);
  }
  return file;
}

/// What was read can be written, and reads again to its end.
void readTwice(const MemoryFile& file, const MemoryFile& copy) {
  auto reader = RecordingReader::open(file.path());
  if (!reader.ok()) return;
  copy.clear();
  std::size_t entries = 0, again = 0;
  {
    auto writer = RecordingWriter::create(copy.path(), reader->header());
    if (!writer.ok()) std::abort();
    while (const auto entry = reader->next()) {
      std::visit([&](const auto& message) { writer->write(entry->time, message); }, entry->message);
      ++entries;
    }
    if (!writer->flush()) std::abort();
  }
  auto second = RecordingReader::open(copy.path());
  if (!second.ok()) std::abort();
  while (second->next()) ++again;
  if (again != entries || !second->damaged().empty()) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const MemoryFile file, copy;
  if (size == 0) return 0;
  const std::span<const std::uint8_t> rest(data + 1, size - 1);
  file.clear();
  if (data[0] % 4 == 0) {
    file.append(rest);
  } else {
    if (!RecordingWriter::create(file.path(), {{}, {{0.1, 0.2, 0.3}, 4.0}})) std::abort();
    file.append(framed(rest));
  }
  readTwice(file, copy);
  return 0;
}
