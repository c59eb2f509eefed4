#pragma once

// Packs integers of any width into bytes and unpacks them.
//
// Bit i of a stream is bit i % 8 of byte i / 8, and a number's least significant bit comes first: a number
// whose width and place are whole bytes is therefore a little-endian integer.
//
// 1. A writer or reader never touches a byte outside its span. Running over the end sets a flag that stays
//    set.
// 2. A reader that has failed returns zeros, so a caller may read a whole record and check once.

#include <cstddef>
#include <cstdint>
#include <span>

namespace tandem::sync {

class BitWriter {
 public:
  /// Writes from the start of `bytes`, which are set to zero first.
  explicit BitWriter(std::span<std::byte> bytes);

  /// Appends the `bits` low bits of `value`; bits in 0..64.
  void put(std::uint64_t value, int bits);
  /// Appends a two's complement number; it must fit.
  void putSigned(std::int64_t value, int bits);
  /// Appends 7 bits at a time, least significant first, each group followed by a bit that says whether more
  /// come.
  void putVarint(std::uint32_t value);

  std::size_t bitCount() const { return position_; }
  /// Whether something did not fit; what fitted is written.
  bool overflowed() const { return overflowed_; }

 private:
  std::span<std::byte> bytes_;
  std::size_t position_ = 0;
  bool overflowed_ = false;
};

class BitReader {
 public:
  explicit BitReader(std::span<const std::byte> bytes) : bytes_(bytes) {}

  /// The next `bits` bits, in 0..64; 0 after a failure.
  std::uint64_t get(int bits);
  std::int64_t getSigned(int bits);
  /// Refuses what putVarint() never writes: more than 32 bits, or a last group of zeros.
  std::uint32_t getVarint();

  std::size_t remaining() const { return failed_ ? 0 : bytes_.size() * 8 - position_; }
  bool failed() const { return failed_; }
  void fail() { failed_ = true; }
  /// Whether nothing is left but the zeros that fill the last byte.
  bool atEnd();

 private:
  std::span<const std::byte> bytes_;
  std::size_t position_ = 0;
  bool failed_ = false;
};

/// Writes the `bits` low bits of `value` over those that stand from `first` on.
void replaceBits(std::span<std::byte> bytes, int first, std::uint64_t value, int bits);

/// Bits that putVarint() uses: 8, 16, 24, 32 or 40.
int varintBits(std::uint32_t value);

}  // namespace tandem::sync
