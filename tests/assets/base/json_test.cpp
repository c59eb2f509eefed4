#include "assets/base/json.h"

#include <cstdint>
#include <limits>
#include <string>

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

TEST(Json, FollowsAPathOfMembersThatNeedNotBeThere) {
  const Result<Json> json = Json::parse(R"({"extras":{"haptic":{"field":null}},"list":[1]})");
  ASSERT_TRUE(json);
  EXPECT_TRUE(json->member("extras").member("haptic").member("field").isNull());
  const Json& missing = json->member("extras").member("other").member("deeper");
  EXPECT_TRUE(missing.isAbsent());
  EXPECT_FALSE(missing.isNull() || missing.isNumber() || missing.isText() || missing.isObject());
  EXPECT_TRUE(missing.empty());
  EXPECT_TRUE(json->member("list").member("length").isAbsent());
  EXPECT_FALSE(json->contains("other"));
}

TEST(Json, SortsTheMembersOfATextAndKeepsTheLastOfOneName) {
  const Result<Json> json = Json::parse(R"({"b":1,"a":[{"y":1,"x":2}],"b":{"c":3}})");
  ASSERT_TRUE(json);
  EXPECT_EQ(json->dump(), R"({"a":[{"x":2,"y":1}],"b":{"c":3}})");
}

TEST(Json, TellsHowAWholeNumberIsWritten) {
  const Result<Json> json = Json::parse("[3, -3, 3.0, 3e0, -0]");
  ASSERT_TRUE(json);
  EXPECT_TRUE(json->at(0).isNatural());
  for (const std::size_t i : {1u, 2u, 3u, 4u}) EXPECT_FALSE(json->at(i).isNatural());
  EXPECT_TRUE(json->at(1).isInteger() && json->at(4).isInteger());
}

TEST(Json, RefusesTextThatNestsTooDeep) {
  const auto nested = [](int depth) {
    const auto count = static_cast<std::size_t>(depth);
    return std::string(count, '[') + std::string(count, ']');
  };
  EXPECT_TRUE(Json::parse(nested(Json::kMaxNesting)));
  const Result<Json> refused = Json::parse(nested(Json::kMaxNesting + 1));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().message, "is nested deeper than 96 levels");
  EXPECT_EQ(Json::nesting(R"({"a":"[[[\"[["})"), 1);
}

TEST(Json, PutsTheReasonOfARefusalOnOneLine) {
  const Result<Json> refused = Json::parse("{\n\"a\": \n}");
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().message.find('\n'), std::string::npos);
  EXPECT_EQ(refused.error().message.find("[json"), std::string::npos);
}

TEST(Json, ErasesAMember) {
  Json json = {{"a", 1}, {"b", 2}};
  json.erase("a");
  json.erase("none");
  EXPECT_EQ(json.dump(), R"({"b":2})");
  EXPECT_EQ(json.find("a"), nullptr);
}

}  // namespace
}  // namespace tandem
