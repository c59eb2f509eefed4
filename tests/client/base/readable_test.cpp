#include "client/base/readable.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <ctime>

namespace tandem::client {
namespace {

TEST(Readable, NumbersHaveThreeDigitsAndNoExponent) {
  EXPECT_EQ(threeDigits(0.0), "0");
  EXPECT_EQ(threeDigits(0.0123456), "0.0123");
  EXPECT_EQ(threeDigits(1.31e3), "1310");
  EXPECT_EQ(threeDigits(999.6), "1000");
  EXPECT_EQ(threeDigits(3e-10), "<0.001");
}

TEST(Readable, LengthsComeInTheUnitThatSuitsThem) {
  EXPECT_EQ(readableLength(1.31e-3), "1.31 mm");
  EXPECT_EQ(readableLength(0.99999e-3), "1 mm");
  EXPECT_EQ(readableLength(2.5e-7), "0.25 um");
  EXPECT_EQ(readableLength(12.345), "12.3 m");
  EXPECT_EQ(readableLength(0.0), "0 um");
}

TEST(Readable, MassesComeInTheUnitThatSuitsThem) {
  EXPECT_EQ(readableMass(0.0176), "17.6 g");
  EXPECT_EQ(readableMass(1.611), "1.61 kg");
  EXPECT_EQ(readableMass(33722.0), "33.7 t");
}

TEST(Readable, TiesAreSaidInPlainWords) {
  haptics::LinkReport links;
  EXPECT_EQ(linkInWords(links), "");
  links.count = links.live = 1;
  links.delay = 0.0272;
  EXPECT_EQ(linkInWords(links), "coming up");
  links.fade = 1.0;
  EXPECT_EQ(linkInWords(links), "stiff (27 ms)");
  links.regime = haptics::LinkRegime::soft;
  EXPECT_EQ(linkInWords(links), "soft: far away (27 ms)");
  links.regime = haptics::LinkRegime::apart;
  links.fresh = false;
  EXPECT_EQ(linkInWords(links), "one at a time: too far away to be felt (27 ms)");
}

TEST(Readable, APeerThatIsSilentIsNotCalledFarAway) {
  haptics::LinkReport links;
  links.count = links.live = 1;
  links.regime = haptics::LinkRegime::apart;  // the age of the last packet grows
  links.delay = 3.022;
  links.fresh = links.heard = false;
  EXPECT_EQ(linkInWords(links), "nothing is heard of the other hand");
  links.count = links.live = 2;
  EXPECT_EQ(linkInWords(links), "nothing is heard of one of them");
}

TEST(Readable, ALinkThatEndsIsNotSaid) {
  haptics::LinkReport links;
  links.count = 1;
  links.regime = haptics::LinkRegime::apart;
  links.delay = 0.384;
  EXPECT_EQ(linkInWords(links), "");
}

TEST(Readable, MemoryComesInDecimalUnits) {
  EXPECT_EQ(readableBytes(512), "512 B");
  EXPECT_EQ(readableBytes(1209), "1.21 kB");
  EXPECT_EQ(readableBytes(345678901), "346 MB");
}

TEST(Readable, ATimeHasItsDayOrYearWhereThatIsAnother) {
  ::setenv("TZ", "UTC-2", 1);  // two hours east
  ::tzset();
  constexpr std::int64_t kNow = 1'795'879'823;  // 2026-11-28 15:30:23 UTC
  EXPECT_EQ(clockTime(kNow - 3600, kNow), "16:30");
  EXPECT_EQ(clockTime(kNow - 18 * 3600, kNow), "27 Nov 23:30");
  EXPECT_EQ(clockTime(kNow - 400 * 86400, kNow), "24 Oct 2025");
  EXPECT_FALSE(clockTime(253'402'300'799, kNow).empty());
  ::unsetenv("TZ");
  ::tzset();
}

}  // namespace
}  // namespace tandem::client
