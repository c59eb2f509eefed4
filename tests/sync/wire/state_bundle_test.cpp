// Several messages in one datagram.

#include <array>
#include <vector>

#include <gtest/gtest.h>

#include "sync/wire/state_bundle.h"
#include "sync/wire/wire.h"

namespace tandem::test {
namespace {

using namespace sync;
using Bytes = std::vector<std::byte>;

/// Bytes that could be a message: version, kind, and padding.
Bytes message(std::size_t size, int fill) {
  Bytes bytes(size, static_cast<std::byte>(fill));
  bytes[0] = std::byte{kStateVersion};
  bytes[1] = std::byte{4};
  return bytes;
}

std::vector<Bytes> split(std::span<const std::byte> datagram) {
  std::vector<Bytes> messages;
  do {
    const std::span<const std::byte> one = popMessage(datagram);
    messages.emplace_back(one.begin(), one.end());
  } while (!datagram.empty());
  return messages;
}

TEST(StateBundle, WhatGoesInComesOutInOrder) {
  StateBundle bundle;
  EXPECT_TRUE(bundle.bytes().empty());
  const std::vector<Bytes> messages{message(39, 1), message(255, 2), message(3, 3), message(600, 4)};
  std::size_t size = 0;
  for (const Bytes& one : messages) {
    ASSERT_TRUE(bundle.add(one));
    size += one.size();
  }
  EXPECT_EQ(bundle.bytes().size(), size + 3 * 3);
  EXPECT_EQ(split(bundle.bytes()), messages);
  bundle.clear();
  ASSERT_TRUE(bundle.add(messages[0]));
  EXPECT_EQ(Bytes(bundle.bytes().begin(), bundle.bytes().end()), messages[0]) << "alone it is as it is";
}

TEST(StateBundle, WhatDoesNotFitIsRefused) {
  StateBundle bundle;
  ASSERT_TRUE(bundle.add(message(256, 1)));
  EXPECT_FALSE(bundle.add(message(10, 2))) << "behind a long one nothing follows";
  bundle.clear();
  ASSERT_TRUE(bundle.add(message(100, 1)));
  EXPECT_FALSE(bundle.add(message(kMaxStateBytes - 102, 2)));
  EXPECT_TRUE(bundle.add(message(kMaxStateBytes - 103, 2)));
  EXPECT_EQ(bundle.bytes().size(), kMaxStateBytes);
  bundle.clear();
  EXPECT_TRUE(bundle.add(message(kMaxStateBytes, 1)));
}

TEST(StateBundle, HostileBytesEnd) {
  std::uint32_t state = 1;
  for (int i = 0; i < 20000; ++i) {
    Bytes bytes;
    state = state * 1664525u + 1013904223u;
    for (std::size_t size = state >> 25; bytes.size() < size;) {
      state = state * 1664525u + 1013904223u;
      // Mostly the bytes of the head of a pair.
      bytes.push_back(
          static_cast<std::byte>(std::array{2u, 7u, state >> 29, state >> 24}[(state >> 20) % 4]));
    }
    std::size_t sum = 0;
    for (const Bytes& one : split(bytes)) sum += one.size();
    EXPECT_LE(sum, bytes.size());
  }
  for (const Bytes& odd :
       {Bytes{}, Bytes{std::byte{2}}, Bytes{std::byte{2}, std::byte{7}, std::byte{0}, std::byte{1}},
        Bytes{std::byte{2}, std::byte{7}, std::byte{1}, std::byte{9}}})
    EXPECT_EQ(split(odd), std::vector<Bytes>{odd}) << "no pair: one message, for the decoder to refuse";
}

}  // namespace
}  // namespace tandem::test
