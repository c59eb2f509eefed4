#pragma once

// The mark: a small file beside the database, `session.mark`, that says how far the journal has come. A
// database that ends before it has lost records that sites were told of.
//
// 1. Four slots of 256 bytes, each with a counter and a checksum. reserve() writes the first two in turn and
//    syncs them; note() writes the other two in turn and does not: the page cache survives the death of the
//    process, and a commit costs no second sync.
// 2. No epoch and no site number beyond the ceilings of the mark was ever told. They are reserved ahead, in
//    blocks.
// 3. A slot can be torn only by a loss of power. So within one boot of the machine every slot must be whole.

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "assets/base/result.h"
#include "server/journal/record_digest.h"

namespace tandem::server {

struct MarkState {
  Digest session{};        // the database's
  Digest key{};            // fingerprint of the server's identity
  Epoch epochCeiling = 0;  // no epoch beyond it was told
  std::uint32_t siteCeiling = 0;
  std::uint64_t sequence = 0;  // of the last commit that is noted
  Digest chain{};              // of that commit
};

class SessionMark {
 public:
  /// The mark in a file; nothing if there is no such file.
  static Result<std::optional<SessionMark>> open(const std::string& path);
  /// A new file in place of any other, synced.
  static Result<SessionMark> create(const std::string& path, const MarkState& state);
  SessionMark(SessionMark&& other) noexcept;
  SessionMark& operator=(SessionMark&&) = delete;
  ~SessionMark();

  const MarkState& state() const { return state_; }
  /// Whether the machine has not been started anew since the mark was written.
  bool sameBoot() const { return sameBoot_; }

  /// The database has come to this commit. Not synced.
  Status note(std::uint64_t sequence, const Digest& chain);
  /// Raises the ceilings to at least these, and syncs all that was noted.
  Status reserve(Epoch epoch, std::uint32_t site);
  /// Whether no path leads to the file any more.
  bool isDeleted() const;

 private:
  SessionMark(std::string path, int file) : path_(std::move(path)), file_(file) {}
  Status readSlots();
  Status writeSlot(std::size_t slot);

  std::string path_;
  int file_ = -1;
  MarkState state_;
  bool sameBoot_ = true;
  std::uint64_t counter_ = 0;
  bool oddNote_ = false, oddReserve_ = false;
};

}  // namespace tandem::server
