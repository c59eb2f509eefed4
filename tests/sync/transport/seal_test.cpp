#include "sync/transport/seal.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <set>
#include <vector>

namespace tandem::sync {
namespace {

constexpr std::uint64_t kConnection = 0x0123456789abcdefULL;
using Bytes = std::vector<std::byte>;

SealKey keyOf(unsigned seed) {
  std::mt19937 random(seed);
  SealKey key;
  for (auto& byte : key.key) byte = static_cast<std::byte>(random() & 0xff);
  for (auto& byte : key.iv) byte = static_cast<std::byte>(random() & 0xff);
  return key;
}

Bytes randomBytes(std::size_t size, unsigned seed = 1) {
  std::mt19937 random(seed);
  Bytes bytes(size);
  for (auto& byte : bytes) byte = static_cast<std::byte>(random() & 0xff);
  return bytes;
}

std::vector<SealAlgorithm> algorithmsHere() {
  std::vector<SealAlgorithm> algorithms{SealAlgorithm::chaCha20Poly1305};
  if ((offeredAlgorithms() & 1) != 0) algorithms.push_back(SealAlgorithm::aes256Gcm);
  return algorithms;
}

Bytes sealed(Sealer& sealer, const Bytes& plain, DatagramKind kind = DatagramKind::state) {
  Bytes out(plain.size() + kSealOverheadBytes);
  EXPECT_EQ(sealer.seal(kind, plain, out.data()), out.size());
  return out;
}

class SealWith : public testing::TestWithParam<SealAlgorithm> {
 protected:
  Sealer sealer_{GetParam(), keyOf(1), kConnection};
  Opener opener_{GetParam(), keyOf(1), kConnection};
  Bytes out_ = Bytes(2048);
};
INSTANTIATE_TEST_SUITE_P(Algorithms, SealWith, testing::ValuesIn(algorithmsHere()));

TEST_P(SealWith, OpensWhatWasSealed) {
  for (const std::size_t size : {0u, 1u, 15u, 16u, 17u, 120u, 1200u}) {
    const Bytes plain = randomBytes(size, static_cast<unsigned>(size) + 1);
    const auto opened = opener_.open(sealed(sealer_, plain, DatagramKind::probe), out_.data());
    EXPECT_EQ(opened.verdict, Opener::Verdict::accepted);
    EXPECT_EQ(opened.kind, DatagramKind::probe);
    EXPECT_TRUE(opened.newest);
    ASSERT_EQ(opened.size, size);
    EXPECT_TRUE(std::equal(plain.begin(), plain.end(), out_.begin()));
  }
}

TEST_P(SealWith, RefusesAnyChangedBit) {
  const Bytes good = sealed(sealer_, randomBytes(40));
  for (std::size_t bit = 0; bit < good.size() * 8; ++bit) {
    Bytes bad = good;
    bad[bit / 8] ^= static_cast<std::byte>(1u << bit % 8);
    EXPECT_EQ(opener_.open(bad, out_.data()).verdict,
              bit == 120 ? Opener::Verdict::replayed : Opener::Verdict::forged)  // counter 1 becomes 0
        << bit;
  }
  EXPECT_EQ(opener_.open(good, out_.data()).verdict, Opener::Verdict::accepted);
}

TEST_P(SealWith, RefusesTruncationAndOtherKeys) {
  const Bytes good = sealed(sealer_, randomBytes(40));
  for (std::size_t size = 0; size < good.size(); ++size) {
    EXPECT_EQ(opener_.open(std::span(good).first(size), out_.data()).verdict, Opener::Verdict::forged);
  }
  Opener other(GetParam(), keyOf(2), kConnection);
  EXPECT_EQ(other.open(good, out_.data()).verdict, Opener::Verdict::forged);
  Opener elsewhere(GetParam(), keyOf(1), kConnection + 1);
  EXPECT_EQ(elsewhere.open(good, out_.data()).verdict, Opener::Verdict::forged);
}

TEST_P(SealWith, EqualTextsNeverLookEqual) {
  std::set<Bytes> seen;
  const Bytes plain = randomBytes(32);
  for (int i = 0; i < 500; ++i) {
    const Bytes datagram = sealed(sealer_, plain);
    EXPECT_TRUE(seen.insert(Bytes(datagram.begin() + kSealHeaderBytes, datagram.end())).second);
  }
}

TEST_P(SealWith, RefusesToUseAKeyUp) {
  sealer_.skipTo(kSealCounterLimit - 2);
  EXPECT_EQ(opener_.open(sealed(sealer_, randomBytes(8)), out_.data()).verdict, Opener::Verdict::accepted);
  Bytes out(8 + kSealOverheadBytes);
  EXPECT_EQ(sealer_.seal(DatagramKind::state, randomBytes(8), out.data()), 0u);
}

TEST_P(SealWith, ReorderedOpenOnceAndReplaysNever) {
  std::vector<Bytes> datagrams;
  for (int i = 0; i < 600; ++i) datagrams.push_back(sealed(sealer_, randomBytes(16)));
  std::shuffle(datagrams.begin(), datagrams.end(), std::mt19937(3));
  for (const auto& datagram : datagrams)
    EXPECT_EQ(opener_.open(datagram, out_.data()).verdict, Opener::Verdict::accepted);
  for (const auto& datagram : datagrams)
    EXPECT_EQ(opener_.open(datagram, out_.data()).verdict, Opener::Verdict::replayed);
}

/// A forgery with a far counter, by an attacker who has seen one genuine datagram.
Bytes forgedFrom(const Bytes& genuine, std::uint8_t counterByte) {
  Bytes forged = genuine;
  forged[13] = std::byte{counterByte};
  return forged;
}

TEST_P(SealWith, ForgeriesDoNotMoveTheWindow) {
  const Bytes first = sealed(sealer_, randomBytes(16));
  const Bytes second = sealed(sealer_, randomBytes(16));
  EXPECT_EQ(opener_.open(forgedFrom(first, 9), out_.data()).verdict, Opener::Verdict::forged);
  EXPECT_EQ(opener_.open(second, out_.data()).verdict, Opener::Verdict::accepted);
  EXPECT_EQ(opener_.open(first, out_.data()).verdict, Opener::Verdict::accepted);
}

// The negative control of the test above: marking a counter before the tag has verified lets one forgery
// block all genuine datagrams.
TEST_P(SealWith, MarkingBeforeVerifyingWouldLetAForgeryShutGenuineDatagramsOut) {
  const Bytes first = sealed(sealer_, randomBytes(16));
  const Bytes forged = forgedFrom(first, 9);
  ReplayWindow window;
  const auto openWrongly = [&](const Bytes& datagram) {
    std::uint64_t counter = 0;
    for (std::size_t i = 10; i < 16; ++i)
      counter = counter << 8 | std::to_integer<std::uint64_t>(datagram[i]);
    if (!window.fresh(counter)) return Opener::Verdict::replayed;
    window.mark(counter);
    return opener_.open(datagram, out_.data()).verdict;
  };
  EXPECT_EQ(openWrongly(forged), Opener::Verdict::forged);
  EXPECT_EQ(openWrongly(first), Opener::Verdict::replayed);
}

TEST(ReplayWindow, AgreesWithASetOfEverythingSeen) {
  std::mt19937_64 random(7);
  ReplayWindow window;
  std::set<std::uint64_t> seen;
  std::uint64_t highest = 0;
  for (int i = 0; i < 20000; ++i) {
    const std::uint64_t jump = random() % 100 == 0 ? random() % 5000 : random() % 8;
    const std::uint64_t back = random() % 1500;
    const std::uint64_t counter = random() % 2 == 0 ? highest + jump : highest - std::min(highest, back);
    const bool expected = counter != 0 && !seen.contains(counter) &&
                          (counter > highest || highest - counter < ReplayWindow::kWindow);
    ASSERT_EQ(window.fresh(counter), expected) << counter << " below " << highest;
    if (!expected) continue;
    window.mark(counter);
    seen.insert(counter);
    highest = std::max(highest, counter);
    ASSERT_EQ(window.highest(), highest);
  }
}

TEST(ReplayWindow, SurvivesTheLargestJump) {
  ReplayWindow window;
  window.mark(5);
  window.mark(kSealCounterLimit - 1);
  EXPECT_FALSE(window.fresh(5));
  EXPECT_FALSE(window.fresh(kSealCounterLimit - 1));
  EXPECT_TRUE(window.fresh(kSealCounterLimit - 2));
}

TEST(ChooseAlgorithm, TakesAesOnlyWhereBothHaveIt) {
  EXPECT_EQ(chooseAlgorithm(3, 3), SealAlgorithm::aes256Gcm);
  EXPECT_EQ(chooseAlgorithm(2, 3), SealAlgorithm::chaCha20Poly1305);
  EXPECT_EQ(chooseAlgorithm(3, 2), SealAlgorithm::chaCha20Poly1305);
  EXPECT_NE(offeredAlgorithms() & 2, 0);
}

}  // namespace
}  // namespace tandem::sync
