#include "client/session/backoff.h"

#include <gtest/gtest.h>

namespace tandem::client {
namespace {

TEST(Backoff, DoublesUpToTheLongestDelayAndBeginsAnewAfterASuccess) {
  Backoff backoff(100, 300);
  EXPECT_TRUE(backoff.due(0));
  backoff.failed(1000);
  EXPECT_FALSE(backoff.due(1099));
  EXPECT_TRUE(backoff.due(1100));
  backoff.failed(1100);
  EXPECT_FALSE(backoff.due(1299));
  EXPECT_TRUE(backoff.due(1300));
  for (int i = 0; i < 2; ++i) {
    backoff.failed(2000);
    EXPECT_FALSE(backoff.due(2299));
    EXPECT_TRUE(backoff.due(2300));
  }
  backoff.succeeded();
  backoff.failed(3000);
  EXPECT_TRUE(backoff.due(3100));
}

}  // namespace
}  // namespace tandem::client
