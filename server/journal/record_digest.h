#pragma once

// Checksums of journal records (BLAKE2b, RFC 7693, 128 bits), by which a start finds damage.

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "server/journal/journal.h"

namespace tandem::server {

using Digest = std::array<std::uint8_t, 16>;

Digest digestOf(std::string_view bytes);
/// 16 random bytes.
Digest randomDigest();

/// Bytes to be hashed or stored: numbers little-endian, texts with their length.
class Bytes {
 public:
  Bytes() { bytes_.reserve(256); }
  Bytes& number(std::uint64_t value);
  Bytes& real(double value);
  Bytes& text(std::string_view value);
  Bytes& digest(const Digest& value);
  const std::string& view() const { return bytes_; }

 private:
  std::string bytes_;
};

/// The checksum of a record in the session `session`, written as number `sequence`.
Digest digestOf(const JournalRecord& record, std::uint64_t sequence, const Digest& session);

/// A checksum of a set of records, whatever their order: the sum of theirs (Bellare and Micciancio, "A new
/// paradigm for collision-free hashing: incrementality at reduced cost", EUROCRYPT 1997). It guards against
/// accidents, not against forgers.
class DigestSum {
 public:
  void add(const Digest& digest) { change(digest, false); }
  void remove(const Digest& digest) { change(digest, true); }
  Digest value() const;
  friend bool operator==(const DigestSum&, const DigestSum&) = default;

 private:
  void change(const Digest& digest, bool remove);
  std::array<std::uint64_t, 2> halves_{};
};

}  // namespace tandem::server
