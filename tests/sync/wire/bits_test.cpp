// Numbers of any width, packed and unpacked, against a stream that is kept bit by bit.

#include "sync/wire/bits.h"

#include <gtest/gtest.h>

#include <random>
#include <span>
#include <vector>

namespace tandem::sync {
namespace {

struct Number {
  std::uint64_t value = 0;  // may have bits above its width, which are not written
  int bits = 0;
};

std::vector<Number> numbersUpTo(std::mt19937_64& random, std::size_t bits) {
  std::vector<Number> numbers;
  for (std::size_t used = 0;;) {
    const Number next{random(), static_cast<int>(random() % 65)};
    used += static_cast<std::size_t>(next.bits);
    if (used > bits) return numbers;
    numbers.push_back(next);
  }
}

std::vector<std::byte> packedBitByBit(const std::vector<Number>& numbers, std::size_t bytes) {
  std::vector<std::byte> packed(bytes);
  std::size_t at = 0;
  for (const Number& number : numbers)
    for (int bit = 0; bit < number.bits; ++bit, ++at)
      packed[at / 8] |= static_cast<std::byte>((number.value >> bit & 1u) << at % 8);
  return packed;
}

TEST(Bits, NumbersOfAnyWidthAtAnyPlaceAreWhatABitByBitStreamHolds) {
  std::mt19937_64 random(1);
  for (int run = 0; run < 3000; ++run) {
    const std::size_t bytes = random() % 41;
    const std::vector<Number> numbers = numbersUpTo(random, 8 * bytes);
    std::vector<std::byte> packed(bytes, std::byte{0xff});
    BitWriter writer(packed);
    for (const Number& number : numbers) writer.put(number.value, number.bits);
    ASSERT_FALSE(writer.overflowed());
    ASSERT_EQ(packed, packedBitByBit(numbers, bytes)) << run;

    BitReader reader(packed);
    for (const Number& number : numbers) {
      const std::uint64_t mask =
          number.bits == 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << number.bits) - 1;
      ASSERT_EQ(reader.get(number.bits), number.value & mask) << run;
    }
    ASSERT_FALSE(reader.failed());
  }
}

TEST(Bits, ANumberThatDoesNotFitIsNotWrittenAndNoByteBehindTheStreamIsTouched) {
  for (std::size_t bytes = 0; bytes <= 17; ++bytes) {
    for (int first = 0; first <= 64; ++first) {
      if (static_cast<std::size_t>(first) > 8 * bytes) continue;
      std::vector<std::byte> memory(bytes + 16, std::byte{0xa5});
      BitWriter writer(std::span<std::byte>(memory).first(bytes));
      writer.put(~std::uint64_t{0}, first);
      const bool fits = static_cast<std::size_t>(first) + 61 <= 8 * bytes;
      writer.put(~std::uint64_t{0}, 61);
      EXPECT_EQ(writer.overflowed(), !fits) << bytes << ' ' << first;
      EXPECT_EQ(writer.bitCount(), static_cast<std::size_t>(first) + (fits ? 61 : 0));
      for (std::size_t i = bytes; i < memory.size(); ++i) ASSERT_EQ(memory[i], std::byte{0xa5});

      BitReader reader(std::span<const std::byte>(memory).first(bytes));
      reader.get(first);
      EXPECT_EQ(reader.get(61), fits ? ~std::uint64_t{0} >> 3 : 0u) << bytes << ' ' << first;
      EXPECT_EQ(reader.failed(), !fits);
    }
  }
}

TEST(Bits, SignedNumbersAndVarintsComeBack) {
  std::mt19937_64 random(2);
  std::vector<std::byte> bytes(64);
  for (int run = 0; run < 1000; ++run) {
    const int bits = 1 + static_cast<int>(random() % 64);
    const auto number = static_cast<std::int64_t>(random()) >> (64 - bits);
    const auto count = static_cast<std::uint32_t>(random() >> (32 + random() % 32));
    BitWriter writer(bytes);
    writer.put(0, static_cast<int>(random() % 30));
    const auto before = static_cast<int>(writer.bitCount());
    writer.putSigned(number, bits);
    writer.putVarint(count);
    EXPECT_EQ(static_cast<int>(writer.bitCount()), before + bits + varintBits(count));

    BitReader reader(bytes);
    reader.get(before);
    EXPECT_EQ(reader.getSigned(bits), number);
    EXPECT_EQ(reader.getVarint(), count);
  }
}

}  // namespace
}  // namespace tandem::sync
