#include "assets/base/json.h"

#include <cstdint>
#include <limits>

#include <gtest/gtest.h>

namespace tandem {
namespace {

TEST(Json, RoundsAwayTheTailsOfBinaryFractions) {
  const Json json = {{"z", 77.82300000000001},
                     {"a", {1e-12 / 3.0, 3, -0.0}},
                     {"none", nullptr},
                     {"text", "0.30000000000000004"}};
  EXPECT_EQ(json.rounded().dump(),
            R"({"z":77.823,"a":[3.33333333e-13,3,-0.0],"none":null,"text":"0.30000000000000004"})");
}

TEST(Json, KeepsMembersInTheOrderInWhichTheyCame) {
  Json json;
  json["b"] = 1;
  json["a"]["deep"] = true;
  json["b"] = 2;
  EXPECT_EQ(json.dump(), R"({"b":2,"a":{"deep":true}})");
}

TEST(Json, ReadsBackEveryWholeNumberExactly) {
  const Json json = {std::numeric_limits<std::int64_t>::min(), std::numeric_limits<std::uint64_t>::max(), -1,
                     0u};
  const std::string text = json.dump();
  EXPECT_EQ(text, "[-9223372036854775808,18446744073709551615,-1,0]");
  const Result<Json> read = Json::parse(text);
  ASSERT_TRUE(read);
  EXPECT_EQ(read->dump(), text);
  EXPECT_EQ(read->at(1).integer(), std::numeric_limits<std::uint64_t>::max());
  EXPECT_THROW(static_cast<void>(read->at(2).integer()), JsonError);
}

TEST(Json, SaysWhatIsMissingOrOfAnotherKind) {
  const Json json = {{"a", 1.5}};
  EXPECT_THROW(static_cast<void>(json.at("b")), JsonError);
  EXPECT_THROW(static_cast<void>(json.at("a").text()), JsonError);
  EXPECT_THROW(static_cast<void>(json.at("a").at(0)), JsonError);
  EXPECT_THROW(static_cast<void>(json.at("a").integer()), JsonError);
  EXPECT_FALSE(Json::parse("{\"a\": }"));
  EXPECT_FALSE(Json::parse(""));
}

}  // namespace
}  // namespace tandem
