#include "sync/wire/recording.h"

#include <array>
#include <bit>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <vector>

#include "assets/base/assert.h"

namespace tandem::sync {
namespace {

// Sizes in bytes.
// - Header: magic 8, scene hash 32, frame centre 3 x 8, half extent 8, CRC-32 of all that 4.
// - Record: payload length 4, kind 1 (0 control, 1 state), session time 8, payload, CRC-32 of all that 4.
constexpr char kMagic[] = "TNDMREC1";
constexpr std::size_t kHeaderBytes = 8 + 32 + 32 + 4, kRecordHead = 4 + 1 + 8, kCrcBytes = 4;

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
  state->file.reset(std::fopen(path.c_str(), "wb"));
  if (!state->file) return Error{path + ": cannot create the recording: " + std::strerror(errno)};
  state->put(headerBytes(header));
  RecordingWriter writer(std::move(state));
  if (Status s = writer.flush(); !s) return s.error();
  return writer;
}

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
  std::vector<std::byte> record;
  std::string damaged;
  bool ended = false;

  /// Appends up to `count` bytes of the file to the record; returns how many there were.
  std::size_t read(std::size_t count) {
    const std::size_t at = record.size();
    record.resize(at + count);
    const std::size_t got = std::fread(record.data() + at, 1, count, file.get());
    record.resize(at + got);
    return got;
  }
  std::optional<RecordingEntry> end(const std::string& why) {
    damaged = why;
    ended = true;
    return std::nullopt;
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
const std::string& RecordingReader::damaged() const { return state_->damaged; }

std::optional<RecordingEntry> RecordingReader::next() {
  if (state_->ended) return std::nullopt;
  state_->record.clear();
  const std::size_t head = state_->read(kRecordHead);
  if (head == 0) return state_->end("");
  if (head < kRecordHead) return state_->end("the last record is cut off");
  const std::size_t size = getNumber(state_->record, 0, 4);
  if (size > kMaxControlBytes) return state_->end("a record's length is out of range");
  if (state_->read(size + kCrcBytes) != size + kCrcBytes) return state_->end("the last record is cut off");

  const std::span<const std::byte> bytes(state_->record);
  if (crc32(bytes.first(kRecordHead + size)) != getNumber(bytes, kRecordHead + size, 4)) {
    return state_->end("a record's checksum is wrong");
  }
  RecordingEntry entry;
  entry.time = static_cast<Micros>(getNumber(bytes, 5, 8));
  if (entry.time > kMaxMicros || entry.time < -kMaxMicros)
    return state_->end("a record's time is out of range");
  const std::span<const std::byte> payload = bytes.subspan(kRecordHead, size);
  const std::uint64_t kind = getNumber(bytes, 4, 1);
  if (kind == 0) {
    Result<ControlMessage> message = decodeControl(payload);
    if (!message.ok()) return state_->end(message.error().message);
    entry.message = std::move(*message);
  } else if (kind == 1) {
    StateMessage message;
    if (Status s = decodeState(payload, state_->header.frame, message); !s)
      return state_->end(s.error().message);
    entry.message = std::move(message);
  } else {
    return state_->end("a record is of an unknown kind");
  }
  return entry;
}

}  // namespace tandem::sync
