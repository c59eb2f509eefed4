#include "client/base/loss_meter.h"

#include <gtest/gtest.h>

namespace tandem::client {
namespace {

TEST(LossMeter, CountsNothingThatWasSentBeforeTheOtherEndListened) {
  LossMeter meter;
  meter.observe(10, 0);
  EXPECT_EQ(meter.loss(), 0.0);
  meter.observe(25, 12);  // thirteen were sent before the other end listened
  meter.observe(125, 112);
  EXPECT_EQ(meter.loss(), 0.0);
}

TEST(LossMeter, CountsWhatIsLostFromThenOn) {
  LossMeter meter;
  meter.observe(25, 12);
  meter.observe(125, 87);
  EXPECT_DOUBLE_EQ(meter.loss(), 0.25);
  meter.observe(225, 187);
  EXPECT_DOUBLE_EQ(meter.loss(), 0.125);
}

TEST(LossMeter, StaysAShareWhereDatagramsCameTwice) {
  LossMeter meter;
  meter.observe(10, 10);
  meter.observe(20, 25);
  EXPECT_EQ(meter.loss(), 0.0);
}

}  // namespace
}  // namespace tandem::client
