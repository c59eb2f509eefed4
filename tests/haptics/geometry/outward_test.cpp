#include "haptics/geometry/outward.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace tandem::test {
namespace {

using haptics::below;
using haptics::roundDown;
using haptics::roundUp;

constexpr float kInfinity = std::numeric_limits<float>::infinity();

float stepDown(float f) { return std::nextafter(f, -kInfinity); }

TEST(Outward, BelowIsTheNextFloat) {
  for (const float f : {1.0f, -1.0f, 0.0f, 3.5e-41f, -3.5e-41f, std::numeric_limits<float>::min(),
                        std::numeric_limits<float>::denorm_min(), std::numeric_limits<float>::max()}) {
    EXPECT_EQ(below(f), stepDown(f)) << f;
  }
  EXPECT_EQ(below(-0.0f), stepDown(0.0f));
}

/// The tightest floats around x, by the standard library.
void expectTightest(double x) {
  const float nearest = static_cast<float>(x);
  const float down = static_cast<double>(nearest) > x ? stepDown(nearest) : nearest;
  const float up = static_cast<double>(nearest) < x ? std::nextafter(nearest, kInfinity) : nearest;
  EXPECT_EQ(roundDown(x), down) << x;
  EXPECT_EQ(roundUp(x), up) << x;
  EXPECT_LE(static_cast<double>(roundDown(x)), x);
  EXPECT_GE(static_cast<double>(roundUp(x)), x);
}

TEST(Outward, RoundedNumbersEncloseTheExactOneAsTightlyAsFloatsCan) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> mantissa(-1.0, 1.0), exponent(-46.0, 37.0);
  for (int i = 0; i < 2000; ++i) expectTightest(mantissa(random) * std::pow(10.0, exponent(random)));
  for (const double x : {0.0, 1.0, -1.0, 0.1, -0.1, 1e-300, -1e-300, 1e-45, 1e300, -1e300}) expectTightest(x);
}

}  // namespace
}  // namespace tandem::test
