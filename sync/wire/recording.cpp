#include "sync/wire/recording.h"

#include <array>
#include <bit>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <vector>

#include "assets/base/assert.h"

namespace tandem::sync {
namespace {

// Sizes in bytes.
// - Header: magic 8, scene hash 32, frame centre 3 x 8, half extent 8, CRC-32 of all that 4.
// - Record: payload length 4, kind 1 (0 control, 1 state), session time 8, payload, CRC-32 of all that 4.
constexpr char kMagic[] = "TNDMREC1";
constexpr std::size_t kHeaderBytes = 8 + 32 + 32 + 4, kRecordHead = 4 + 1 + 8, kCrcBytes = 4;
constexpr int kMaxNames = 10000;  // of recordings side by side
constexpr std::size_t kSearchBytes = 64 * 1024;
// A file made to be slow could pretend that a record begins at each of its bytes.
constexpr std::size_t kMaxBytesChecked = std::size_t{1} << 26;

constexpr std::array<std::uint32_t, 256> crcTable() {
  std::array<std::uint32_t, 256> table{};
  for (std::uint32_t i = 0; i < 256; ++i) {
    std::uint32_t value = i;
    for (int bit = 0; bit < 8; ++bit) value = value >> 1 ^ (value & 1u ? 0xedb88320u : 0u);
    table[i] = value;
  }
  return table;
}

/// CRC-32 of IEEE 802.3. It detects a write that a crash cut off; it is no protection against an attacker.
std::uint32_t crc32(std::span<const std::byte> bytes) {
  static constexpr auto kTable = crcTable();
  std::uint32_t crc = 0xffffffffu;
  for (const std::byte byte : bytes)
    crc = kTable[(crc ^ std::to_integer<std::uint32_t>(byte)) & 0xffu] ^ crc >> 8;
  return ~crc;
}

void putNumber(std::vector<std::byte>& bytes, std::uint64_t value, int size) {
  for (int i = 0; i < size; ++i) bytes.push_back(static_cast<std::byte>(value >> (8 * i) & 0xffu));
}
std::uint64_t getNumber(std::span<const std::byte> bytes, std::size_t at, int size) {
  std::uint64_t value = 0;
  for (int i = 0; i < size; ++i) {
    value |= std::to_integer<std::uint64_t>(bytes[at + static_cast<std::size_t>(i)]) << (8 * i);
  }
  return value;
}

struct CloseFile {
  void operator()(std::FILE* file) const { std::fclose(file); }
};
using File = std::unique_ptr<std::FILE, CloseFile>;

std::vector<std::byte> headerBytes(const RecordingHeader& header) {
  std::vector<std::byte> bytes;
  for (std::size_t i = 0; i < 8; ++i) bytes.push_back(static_cast<std::byte>(kMagic[i]));
  for (const std::uint8_t byte : header.sceneHash) bytes.push_back(static_cast<std::byte>(byte));
  for (int i = 0; i < 3; ++i) putNumber(bytes, std::bit_cast<std::uint64_t>(header.frame.centre[i]), 8);
  putNumber(bytes, std::bit_cast<std::uint64_t>(header.frame.halfExtent), 8);
  putNumber(bytes, crc32(bytes), 4);
  return bytes;
}

struct Head {
  std::size_t size;  // of the payload
  std::uint64_t kind;
  Micros time;
};
/// Nothing if no record begins like this.
std::optional<Head> parseHead(std::span<const std::byte> bytes) {
  const Head head{getNumber(bytes, 0, 4), getNumber(bytes, 4, 1),
                  static_cast<Micros>(getNumber(bytes, 5, 8))};
  const bool sound = head.size > 0 && head.size <= kMaxControlBytes && head.kind <= 1 &&
                     head.time <= kMaxMicros && head.time >= -kMaxMicros;
  return sound ? std::optional(head) : std::nullopt;
}

/// Makes a file of its own, unless there is an empty one or none that could be written over (a device).
File makeFile(const std::string& path) {
  File made(std::fopen(path.c_str(), "wbx"));
  if (made || errno != EEXIST) return made;
  std::error_code ignored;
  const bool kept =
      std::filesystem::is_regular_file(path, ignored) && std::filesystem::file_size(path, ignored) > 0;
  errno = EEXIST;
  return File(kept ? nullptr : std::fopen(path.c_str(), "wb"));
}

std::string nextName(const std::filesystem::path& path, int number) {
  const std::string name = path.stem().string() + "-" + std::to_string(number) + path.extension().string();
  return (path.parent_path() / name).string();
}

}  // namespace

// ---- writing ----

struct RecordingWriter::State {
  std::string path;
  File file;
  WireFrame frame;
  std::vector<std::byte> record, payload;
  std::string problem;  // the first one; later writes are dropped, since a reader could not pass the gap

  void put(std::span<const std::byte> bytes) {
    if (problem.empty() && std::fwrite(bytes.data(), 1, bytes.size(), file.get()) != bytes.size()) {
      problem = path + ": cannot write: " + std::strerror(errno);
    }
  }
  void write(Micros time, std::uint8_t kind) {
    ASSERT(kind <= 1 && !payload.empty());
    record.clear();
    putNumber(record, payload.size(), 4);
    putNumber(record, kind, 1);
    putNumber(record, static_cast<std::uint64_t>(time), 8);
    record.insert(record.end(), payload.begin(), payload.end());
    putNumber(record, crc32(record), 4);
    put(record);
  }
};

RecordingWriter::RecordingWriter(std::unique_ptr<State> state) : state_(std::move(state)) {}
RecordingWriter::RecordingWriter(RecordingWriter&&) noexcept = default;
RecordingWriter& RecordingWriter::operator=(RecordingWriter&&) noexcept = default;
RecordingWriter::~RecordingWriter() = default;  // closing the file flushes it

Result<RecordingWriter> RecordingWriter::create(const std::string& path, const RecordingHeader& header) {
  auto state = std::make_unique<State>();
  state->path = path;
  state->frame = header.frame;
  state->file = makeFile(path);
  for (int i = 2; !state->file && errno == EEXIST && i <= kMaxNames; ++i)
    state->file = makeFile(state->path = nextName(path, i));
  if (!state->file) return Error{path + ": cannot create the recording: " + std::strerror(errno)};
  state->put(headerBytes(header));
  RecordingWriter writer(std::move(state));
  if (Status s = writer.flush(); !s) return s.error();
  return writer;
}

const std::string& RecordingWriter::path() const { return state_->path; }

void RecordingWriter::write(Micros time, const ControlMessage& message) {
  state_->payload = encodeControl(message);
  state_->write(time, 0);
}

void RecordingWriter::write(Micros time, const StateMessage& message) {
  encodeState(message, state_->frame, state_->payload);
  state_->write(time, 1);
}

Status RecordingWriter::flush() {
  if (state_->problem.empty() && std::fflush(state_->file.get()) != 0) {
    state_->problem = state_->path + ": cannot write: " + std::strerror(errno);
  }
  if (!state_->problem.empty()) return Error{state_->problem};
  return {};
}

// ---- reading ----

struct RecordingReader::State {
  File file;
  RecordingHeader header;
  std::vector<std::byte> record, found;
  off_t at = 0;         // of the record that is next
  std::string problem;  // the first one
  std::size_t places = 0, bytesPassedOver = 0;
  std::size_t bytesChecked = 0;  // of what turned out to be no records
  bool ended = false;

  /// Appends up to `count` bytes of the file to the record; returns how many there were.
  std::size_t read(std::size_t count) {
    const std::size_t before = record.size();
    record.resize(before + count);
    const std::size_t got = std::fread(record.data() + before, 1, count, file.get());
    record.resize(before + got);
    return got;
  }
  void note(const std::string& why, off_t bytes) {
    if (places++ == 0) problem = why;
    bytesPassedOver += static_cast<std::size_t>(bytes);
  }
  /// Reads the next record whole. False where the file ends, or where no record is, which `why` then says.
  bool readRecord(std::string& why) {
    why.clear();
    record.clear();
    if (::fseeko(file.get(), at, SEEK_SET) != 0) return false;
    const std::size_t got = read(kRecordHead);
    if (got == 0) return false;
    const std::optional<Head> head = got == kRecordHead ? parseHead(record) : std::nullopt;
    if (got < kRecordHead || (head && read(head->size + kCrcBytes) != head->size + kCrcBytes))
      return why = "a record is cut off", false;
    if (!head) return why = "no record begins where one should", false;
    const std::span<const std::byte> bytes(record);
    if (crc32(bytes.first(kRecordHead + head->size)) != getNumber(bytes, kRecordHead + head->size, kCrcBytes))
      return why = "a record's checksum is wrong", false;
    return true;
  }
  /// Moves `at` to the next intact record after a damaged one, or to the end of the file.
  void findRecord() {
    std::string ignored;
    for (off_t from = at + 1; bytesChecked <= kMaxBytesChecked; from += static_cast<off_t>(kSearchBytes)) {
      found.resize(kSearchBytes + kRecordHead);
      if (::fseeko(file.get(), from, SEEK_SET) != 0) break;
      found.resize(std::fread(found.data(), 1, found.size(), file.get()));
      const std::span<const std::byte> bytes(found);
      for (std::size_t i = 0; i < kSearchBytes && i + kRecordHead <= bytes.size(); ++i) {
        at = from + static_cast<off_t>(i);
        if (!parseHead(bytes.subspan(i, kRecordHead))) continue;
        if (readRecord(ignored)) return;
        bytesChecked += record.size();
        if (bytesChecked > kMaxBytesChecked) break;
      }
      if (found.size() < kSearchBytes + kRecordHead) break;
    }
    ::fseeko(file.get(), 0, SEEK_END);
    at = ::ftello(file.get());
  }
};

RecordingReader::RecordingReader(std::unique_ptr<State> state) : state_(std::move(state)) {}
RecordingReader::RecordingReader(RecordingReader&&) noexcept = default;
RecordingReader& RecordingReader::operator=(RecordingReader&&) noexcept = default;
RecordingReader::~RecordingReader() = default;

Result<RecordingReader> RecordingReader::open(const std::string& path) {
  auto state = std::make_unique<State>();
  state->file.reset(std::fopen(path.c_str(), "rb"));
  if (!state->file) return Error{path + ": cannot open the recording: " + std::strerror(errno)};
  if (state->read(kHeaderBytes) != kHeaderBytes) return Error{path + ": too short for a recording"};
  state->at = kHeaderBytes;
  const std::span<const std::byte> bytes(state->record);
  if (std::memcmp(bytes.data(), kMagic, 8) != 0) return Error{path + ": not a recording of this version"};
  if (crc32(bytes.first(kHeaderBytes - kCrcBytes)) != getNumber(bytes, kHeaderBytes - kCrcBytes, 4)) {
    return Error{path + ": the header is damaged"};
  }
  for (std::size_t i = 0; i < 32; ++i)
    state->header.sceneHash[i] = std::to_integer<std::uint8_t>(bytes[8 + i]);
  WireFrame& frame = state->header.frame;
  for (std::size_t i = 0; i < 3; ++i) {
    frame.centre[static_cast<int>(i)] = std::bit_cast<double>(getNumber(bytes, 40 + 8 * i, 8));
  }
  frame.halfExtent = std::bit_cast<double>(getNumber(bytes, 64, 8));
  const glm::dvec3 centre = glm::abs(frame.centre);
  const bool near = centre.x < 1e9 && centre.y < 1e9 && centre.z < 1e9;
  if (!near || !(frame.halfExtent > 0.0 && frame.halfExtent < 1e9)) {
    return Error{path + ": the header's position range is not valid"};
  }
  return RecordingReader(std::move(state));
}

const RecordingHeader& RecordingReader::header() const { return state_->header; }
std::string RecordingReader::damaged() const {
  if (state_->places == 0) return {};
  return state_->problem + "; " + std::to_string(state_->bytesPassedOver) + " bytes in " +
         std::to_string(state_->places) + (state_->places == 1 ? " place" : " places") + " passed over";
}

std::optional<RecordingEntry> RecordingReader::next() {
  State& state = *state_;
  while (!state.ended) {
    const off_t begin = state.at;
    std::string why;
    if (!state.readRecord(why)) {
      if (why.empty()) {
        state.ended = true;
        break;
      }
      state.findRecord();
      state.note(why, state.at - begin);
      continue;
    }
    const std::span<const std::byte> bytes(state.record);
    state.at += static_cast<off_t>(bytes.size());
    const Head head = *parseHead(bytes);
    const std::span<const std::byte> payload = bytes.subspan(kRecordHead, head.size);
    RecordingEntry entry;
    entry.time = head.time;
    if (head.kind == 0) {
      Result<ControlMessage> message = decodeControl(payload);
      if (message) {
        entry.message = std::move(*message);
        return entry;
      }
      why = message.error().message;
    } else {
      StateMessage message;
      const Status decoded = decodeState(payload, state.header.frame, message);
      if (decoded) {
        entry.message = std::move(message);
        return entry;
      }
      why = decoded.error().message;
    }
    state.note(why, state.at - begin);
  }
  return std::nullopt;
}

}  // namespace tandem::sync
