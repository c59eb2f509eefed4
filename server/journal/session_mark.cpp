#include "server/journal/session_mark.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <utility>

#include "assets/base/assert.h"
#include "server/journal/durable_file.h"

namespace tandem::server {
namespace {

constexpr std::size_t kSlots = 4, kSlotBytes = 256;
constexpr std::string_view kMagic = "tandem session mark 1\n";
// A reservation that was torn by a loss of power exceeded the one before by less than this.
constexpr Epoch kTornEpochs = 1 << 16;

Digest bootOfMachine() {
  std::ifstream file("/proc/sys/kernel/random/boot_id");
  std::string id;
  std::getline(file, id);
  return digestOf(id);
}

struct Slot {
  MarkState state;
  Digest boot{};
  std::uint64_t counter = 0;
};

std::string encode(const Slot& slot) {
  Bytes bytes;
  bytes.digest(slot.state.session).digest(slot.state.key).digest(slot.state.chain).digest(slot.boot);
  bytes.number(slot.state.epochCeiling).number(slot.state.siteCeiling);
  bytes.number(slot.state.sequence).number(slot.counter);
  std::string text = std::string(kMagic) + bytes.view();
  text.resize(kSlotBytes - sizeof(Digest));
  const Digest check = digestOf(text);
  text.append(check.begin(), check.end());
  ASSERT(text.size() == kSlotBytes);
  return text;
}

/// Nothing if the slot is damaged.
std::optional<Slot> decode(std::string_view text) {
  const std::string_view body = text.substr(0, kSlotBytes - sizeof(Digest));
  const Digest check = digestOf(body);
  if (std::memcmp(check.data(), text.data() + body.size(), check.size()) != 0) return std::nullopt;
  if (body.substr(0, kMagic.size()) != kMagic) return std::nullopt;
  std::size_t at = kMagic.size();
  const auto digest = [&] {
    Digest value{};
    std::memcpy(value.data(), body.data() + at, value.size());
    at += value.size();
    return value;
  };
  const auto number = [&] {
    std::uint64_t value = 0;
    for (int i = 7; i >= 0; --i)
      value = (value << 8) | static_cast<std::uint8_t>(body[at + static_cast<std::size_t>(i)]);
    at += 8;
    return value;
  };
  Slot slot;
  slot.state.session = digest();
  slot.state.key = digest();
  slot.state.chain = digest();
  slot.boot = digest();
  slot.state.epochCeiling = static_cast<Epoch>(number());
  slot.state.siteCeiling = static_cast<std::uint32_t>(number());
  slot.state.sequence = number();
  slot.counter = number();
  return slot;
}

}  // namespace

Result<std::optional<SessionMark>> SessionMark::open(const std::string& path) {
  const int file = ::open(path.c_str(), O_RDWR | O_CLOEXEC | O_NOFOLLOW);
  if (file < 0 && errno == ENOENT) return std::optional<SessionMark>();
  if (file < 0) return Error{path + ": " + std::strerror(errno)};
  SessionMark mark(path, file);
  if (Status read = mark.readSlots(); !read) return read.error();
  return std::optional<SessionMark>(std::move(mark));
}

Status SessionMark::readSlots() {
  std::string text(kSlots * kSlotBytes + 1, '\0');
  const ssize_t size = ::pread(file_, text.data(), text.size(), 0);
  if (size != static_cast<ssize_t>(kSlots * kSlotBytes))
    return Error{path_ + ": damaged: " + std::to_string(std::max<ssize_t>(size, 0)) + " bytes, not 1024"};
  const Digest boot = bootOfMachine();
  const Slot* newest = nullptr;
  std::array<std::optional<Slot>, kSlots> slots;
  bool reserved = false;
  std::optional<std::size_t> torn;
  for (std::size_t i = 0; i < kSlots; ++i) {
    slots[i] = decode(std::string_view(text).substr(i * kSlotBytes, kSlotBytes));
    if (!slots[i]) {
      torn = i;
      continue;
    }
    reserved = reserved || i < 2;
    if (newest == nullptr || slots[i]->counter > newest->counter) newest = &*slots[i];
  }
  sameBoot_ = newest != nullptr && newest->boot == boot;
  if (torn && (sameBoot_ || !reserved))
    return Error{path_ + ": damaged: slot " + std::to_string(*torn) + " has a wrong checksum"};
  state_ = newest->state;
  counter_ = newest->counter;
  for (const auto& slot : slots) {
    if (!slot) continue;
    if (slot->state.session != state_.session || slot->state.key != state_.key)
      return Error{path_ + ": damaged: its slots belong to different sessions"};
    state_.epochCeiling = std::max(state_.epochCeiling, slot->state.epochCeiling);
    state_.siteCeiling = std::max(state_.siteCeiling, slot->state.siteCeiling);
  }
  if (torn) state_.epochCeiling += std::min(kTornEpochs, ~state_.epochCeiling);
  // The next write must not hit the only newest slot.
  oddReserve_ = slots[0] && (!slots[1] || slots[0]->counter > slots[1]->counter);
  oddNote_ = slots[2] && (!slots[3] || slots[2]->counter > slots[3]->counter);
  return {};
}

Result<SessionMark> SessionMark::create(const std::string& path, const MarkState& state) {
  const std::string slot = encode({state, bootOfMachine(), 1});
  std::string text;
  for (std::size_t i = 0; i < kSlots; ++i) text += slot;
  if (Status written = writeDurably(path, text); !written) return written.error();
  auto mark = open(path);
  if (!mark) return mark.error();
  if (!*mark) return Error{path + ": was removed"};
  return std::move(**mark);
}

SessionMark::SessionMark(SessionMark&& other) noexcept
    : path_(std::move(other.path_)),
      file_(std::exchange(other.file_, -1)),
      state_(other.state_),
      sameBoot_(other.sameBoot_),
      counter_(other.counter_),
      oddNote_(other.oddNote_),
      oddReserve_(other.oddReserve_) {}

SessionMark::~SessionMark() {
  if (file_ >= 0) ::close(file_);
}

bool SessionMark::isDeleted() const {
  struct statx now {};
  return ::statx(file_, "", AT_EMPTY_PATH | AT_STATX_DONT_SYNC, STATX_NLINK, &now) != 0 || now.stx_nlink == 0;
}

Status SessionMark::writeSlot(std::size_t slot) {
  static const Digest boot = bootOfMachine();
  const std::string text = encode({state_, boot, ++counter_});
  if (::pwrite(file_, text.data(), text.size(), static_cast<off_t>(slot * kSlotBytes)) !=
      static_cast<ssize_t>(text.size()))
    return Error{path_ + ": " + std::strerror(errno)};
  return {};
}

Status SessionMark::note(std::uint64_t sequence, const Digest& chain) {
  state_.sequence = sequence;
  state_.chain = chain;
  const std::size_t slot = oddNote_ ? 3 : 2;
  oddNote_ = !oddNote_;
  return writeSlot(slot);
}

Status SessionMark::reserve(Epoch epoch, std::uint32_t site) {
  state_.epochCeiling = std::max(state_.epochCeiling, epoch);
  state_.siteCeiling = std::max(state_.siteCeiling, site);
  const std::size_t slot = oddReserve_ ? 1 : 0;
  oddReserve_ = !oddReserve_;
  if (Status written = writeSlot(slot); !written) return written;
  if (::fdatasync(file_) != 0) return Error{path_ + ": " + std::strerror(errno)};
  return {};
}

}  // namespace tandem::server
