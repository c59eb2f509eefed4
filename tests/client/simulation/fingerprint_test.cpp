#include "client/simulation/fingerprint.h"

#include <gtest/gtest.h>

#include <cmath>

namespace tandem::client {
namespace {

TEST(Fingerprint, BeginsWithTheOffsetBasisOfFnv1a) { EXPECT_EQ(Fingerprint{}.hex(), "cbf29ce484222325"); }

TEST(Fingerprint, DiffersWhereOneBitDiffers) {
  Fingerprint a, b, c;
  a.add({1.0, 2.0, 3.0});
  b.add({1.0, 2.0, 3.0});
  c.add({1.0, 2.0, std::nextafter(3.0, 4.0)});
  EXPECT_EQ(a.hex(), b.hex());
  EXPECT_NE(a.hex(), c.hex());
}

}  // namespace
}  // namespace tandem::client
