#include "sync/wire/bits.h"

#include <algorithm>
#include <bit>
#include <cstring>

#include "assets/base/assert.h"

namespace tandem::sync {
namespace {

// Numbers go through whole words where these lie inside the stream: the first byte in memory is the lowest.
static_assert(std::endian::native == std::endian::little);

/// Whether `bits` bits from `position` on lie in the eight bytes from its byte on, and these in the stream.
bool isInAWord(std::size_t position, int bits, std::size_t bytes) {
  return position % 8 + static_cast<std::size_t>(bits) <= 64 && position / 8 + 8 <= bytes;
}

/// The `bits` low bits; bits in 0..64.
std::uint64_t masked(std::uint64_t value, int bits) {
  return bits == 64 ? value : value & ((std::uint64_t{1} << bits) - 1);
}

}  // namespace

BitWriter::BitWriter(std::span<std::byte> bytes) : bytes_(bytes) {
  std::fill(bytes_.begin(), bytes_.end(), std::byte{0});
}

void BitWriter::put(std::uint64_t value, int bits) {
  ASSERT(bits >= 0 && bits <= 64);
  if (position_ + static_cast<std::size_t>(bits) > bytes_.size() * 8) {
    overflowed_ = true;
    return;
  }
  if (isInAWord(position_, bits, bytes_.size())) {
    std::byte* at = bytes_.data() + position_ / 8;
    std::uint64_t word;
    std::memcpy(&word, at, sizeof word);
    word |= masked(value, bits) << position_ % 8;
    std::memcpy(at, &word, sizeof word);
    position_ += static_cast<std::size_t>(bits);
    return;
  }
  while (bits > 0) {
    const int offset = static_cast<int>(position_ % 8);
    const int count = std::min(8 - offset, bits);
    const auto low = static_cast<unsigned>(value & ((1u << count) - 1u));
    bytes_[position_ / 8] |= static_cast<std::byte>(low << offset);
    value >>= count;
    bits -= count;
    position_ += static_cast<std::size_t>(count);
  }
}

void BitWriter::putSigned(std::int64_t value, int bits) {
  ASSERT(bits == 64 ||
         (value >= -(std::int64_t{1} << (bits - 1)) && value < (std::int64_t{1} << (bits - 1))));
  put(static_cast<std::uint64_t>(value), bits);
}

void BitWriter::putVarint(std::uint32_t value) {
  do {
    const std::uint32_t group = value & 0x7fu;
    value >>= 7;
    put(group | (value != 0 ? 0x80u : 0u), 8);
  } while (value != 0);
}

std::uint64_t BitReader::get(int bits) {
  ASSERT(bits >= 0 && bits <= 64);
  if (failed_ || position_ + static_cast<std::size_t>(bits) > bytes_.size() * 8) {
    failed_ = true;
    return 0;
  }
  if (isInAWord(position_, bits, bytes_.size())) {
    std::uint64_t word;
    std::memcpy(&word, bytes_.data() + position_ / 8, sizeof word);
    const std::uint64_t whole = masked(word >> position_ % 8, bits);
    position_ += static_cast<std::size_t>(bits);
    return whole;
  }
  std::uint64_t value = 0;
  for (int done = 0; done < bits;) {
    const int offset = static_cast<int>(position_ % 8);
    const int count = std::min(8 - offset, bits - done);
    const unsigned part = (std::to_integer<unsigned>(bytes_[position_ / 8]) >> offset) & ((1u << count) - 1u);
    value |= static_cast<std::uint64_t>(part) << done;
    done += count;
    position_ += static_cast<std::size_t>(count);
  }
  return value;
}

std::int64_t BitReader::getSigned(int bits) {
  ASSERT(bits >= 1 && bits <= 64);
  const std::uint64_t raw = get(bits);
  const std::uint64_t sign = std::uint64_t{1} << (bits - 1);
  return static_cast<std::int64_t>((raw ^ sign) - sign);
}

std::uint32_t BitReader::getVarint() {
  std::uint64_t value = 0;
  for (int shift = 0; shift < 35; shift += 7) {
    const std::uint64_t group = get(8);
    value |= (group & 0x7fu) << shift;
    if ((group & 0x80u) == 0) {
      if ((shift > 0 && group == 0) || value > 0xffffffffu) break;
      return static_cast<std::uint32_t>(value);
    }
  }
  failed_ = true;
  return 0;
}

bool BitReader::atEnd() {
  if (failed_ || remaining() >= 8) return false;
  return get(static_cast<int>(remaining())) == 0;
}

void replaceBits(std::span<std::byte> bytes, int first, std::uint64_t value, int bits) {
  ASSERT(first >= 0 && bits >= 0 && static_cast<std::size_t>(first + bits) <= bytes.size() * 8);
  for (int done = 0; done < bits;) {
    const int offset = (first + done) % 8;
    const int count = std::min(8 - offset, bits - done);
    const unsigned mask = ((1u << count) - 1u) << offset;
    std::byte& byte = bytes[static_cast<std::size_t>(first + done) / 8];
    byte = (byte & static_cast<std::byte>(~mask)) |
           static_cast<std::byte>((static_cast<unsigned>(value >> done) << offset) & mask);
    done += count;
  }
}

int varintBits(std::uint32_t value) {
  int bits = 8;
  while (value >>= 7) bits += 8;
  return bits;
}

}  // namespace tandem::sync
