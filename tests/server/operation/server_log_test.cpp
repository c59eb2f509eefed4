#include "server/operation/server_log.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <random>

#include "server/operation/log_limiter.h"

namespace tandem::server {
namespace {

using sync::kSecond;
using sync::Micros;

TEST(ServerLog, AnyBytesGiveOneLineOfJsonWithSessionAndSite) {
  std::mt19937 random(5);
  for (int i = 0; i < 2000; ++i) {
    std::string text;
    for (std::size_t n = random() % 80; n > 0; --n) text += static_cast<char>(random() % 256);
    const std::string line =
        logLineInJson(1700000000123 + i, "info", "ab12", static_cast<SiteId>(i % 5), text);
    EXPECT_EQ(line.find('\n'), std::string::npos);
    const auto object = nlohmann::json::parse(line, nullptr, false);
    ASSERT_TRUE(object.is_object()) << line;
    EXPECT_EQ(object.at("session"), "ab12");
    EXPECT_EQ(object.contains("site"), i % 5 != 0);
  }
  EXPECT_EQ(logLineInJson(1700000000123, "warning", "", 7, "a \"b\""),
            R"({"time":"2023-11-14T22:13:20.123Z","level":"warning","site":7,"message":"a \"b\""})");
}

TEST(LogLimiter, CountsWhatItLeavesOutAndLosesNoLine) {
  LogLimiter limiter;
  std::uint64_t written = 0, counted = 0;
  const auto drain = [&](Micros now) {
    for (const LogLine& line : limiter.drainCounts(now)) {
      ASSERT_EQ(line.text.rfind("... ", 0), 0u) << line.text;
      counted += std::stoull(line.text.substr(4));
    }
  };
  Micros now = 0;
  for (int i = 0; i < 30000; ++i, now += kSecond / 500) {
    drain(now);
    const LogLine line{"connection " + std::to_string(i) + " refused (credential not valid): no", false};
    if (limiter.admit(line, now)) ++written;
  }
  drain(now + LogLimiter::kWindow);
  EXPECT_EQ(written + counted, 30000u);
  EXPECT_LE(written, 7u * LogLimiter::kLines);
}

TEST(LogLimiter, AFloodHidesNeitherOtherLinesNorErrors) {
  LogLimiter limiter;
  for (int i = 0; i < 1000; ++i) limiter.admit({"connection " + std::to_string(i) + " refused"}, 0);
  EXPECT_FALSE(limiter.admit({"connection 7 refused"}, kSecond));
  EXPECT_TRUE(limiter.admit({"site 1 \"Ada\" joined"}, kSecond));
  for (int i = 0; i < 100; ++i) EXPECT_TRUE(limiter.admit({"journal: disk full", true}, kSecond));
}

TEST(LogLimiter, KindsThatNeverEndAreBounded) {
  LogLimiter limiter;
  int written = 0;
  for (int i = 0; i < 100000; ++i) {
    std::string name;
    for (int n = i; n > 0; n /= 26) name += static_cast<char>('a' + n % 26);
    written += limiter.admit({name + " refused"}, 0) ? 1 : 0;
  }
  EXPECT_LE(written, static_cast<int>(LogLimiter::kKinds) + LogLimiter::kLines);
}

}  // namespace
}  // namespace tandem::server
