// Time stamps of files.

#include "assets/base/utc_time.h"

#include <gtest/gtest.h>

namespace tandem {
namespace {

TEST(UtcTime, IsWrittenAsTheCalendarHasIt) {
  EXPECT_EQ(utcText(0), "1970-01-01T00:00:00Z");
  EXPECT_EQ(utcText(951782399), "2000-02-28T23:59:59Z");
  EXPECT_EQ(utcText(951782400), "2000-02-29T00:00:00Z");
  EXPECT_EQ(utcText(1773065100), "2026-03-09T14:05:00Z");
  EXPECT_EQ(utcText(-1), "1969-12-31T23:59:59Z");
  EXPECT_EQ(utcText(-62135596800), "0001-01-01T00:00:00Z");
  EXPECT_EQ(utcText(253402300799), "9999-12-31T23:59:59Z");
}

TEST(UtcTime, KeepsWithinFourDigitsOfYears) {
  EXPECT_EQ(utcText(INT64_MAX), "9999-12-31T23:59:59Z");
  EXPECT_EQ(utcText(INT64_MIN), "0001-01-01T00:00:00Z");
}

TEST(UtcTime, ComesBack) {
  for (std::int64_t time = -62135596800; time <= 253402300799; time += 86399 * 977)
    ASSERT_EQ(utcTime(utcText(time)), time) << utcText(time);
}

TEST(UtcTime, TakesZonesAndFractions) {
  EXPECT_EQ(utcTime("2026-03-09T15:05:00.999+01:00"), 1773065100);
  EXPECT_EQ(utcTime("2026-03-09T09:35:00-04:30"), 1773065100);
  EXPECT_EQ(utcTime("2026-03-09T14:05:00"), 1773065100);
  EXPECT_EQ(utcTime("2026-03-08T24:00:00Z"), utcTime("2026-03-09T00:00:00Z"));
}

TEST(UtcTime, RefusesWhatIsNone) {
  for (const char* text :
       {"", "x", "2026", "2026-03-09", "2026-02-29T00:00:00Z", "2026-13-01T00:00:00Z", "2026-03-09T25:00:00Z",
        "2026-03-09T24:00:01Z", "2026-03-09T14:60:00Z", "2026-03-09T14:05:61Z", "2026-03-09T14:05:00.Z",
        "2026-03-09T14:05:00+15:00", "2026-03-09T14:05:00+1:00", "2026-03-09T14:05:00Zx",
        "0000-01-01T00:00:00Z", "-026-03-09T14:05:00Z", "2026-03-09 14:05:00Z", " 2026-03-09T14:05:00Z",
        "20260-03-09T14:05:00Z"})
    EXPECT_FALSE(utcTime(text)) << text;
}

}  // namespace
}  // namespace tandem
