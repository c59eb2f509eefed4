#include "client/session/scene_fetch.h"

#include <gtest/gtest.h>

namespace tandem::client {
namespace {

TEST(SceneFetch, HoldsNoPackageThatWasTaken) {
  const std::vector<std::byte> whole(1000, std::byte{7}), half(500, std::byte{7});
  SceneFetch fetch;
  fetch.expect(whole.size());
  EXPECT_EQ(fetch.start(half).offset, half.size());
  sync::SceneChunk chunk;
  chunk.offset = half.size();
  chunk.bytes.assign(half.size(), 7);
  ASSERT_TRUE(fetch.handle(chunk));
  ASSERT_TRUE(fetch.complete());
  EXPECT_EQ(fetch.take(), whole);
  EXPECT_EQ(fetch.package().capacity(), 0u);
  EXPECT_FALSE(fetch.handle(chunk)) << "nothing is on its way";
}

}  // namespace
}  // namespace tandem::client
