#include "assets/gltf/gltf_json.h"

#include <string>

#include <gtest/gtest.h>

namespace tandem::assets {
namespace {

constexpr const char* kNames[] = {"", "box", "sphere", "cone"};
enum class Shape { none, box, sphere, cone };

class JsonObjectTest : public ::testing::Test {
 protected:
  JsonObject parsed(const std::string& text) {
    document_ = Json::parse(text).value();
    return JsonObject(document_, "place");
  }

 private:
  Json document_;
};

TEST_F(JsonObjectTest, ReadsAChoiceByTheNamesOfItsValues) {
  const JsonObject object = parsed(R"({"shape":"cone"})");
  EXPECT_EQ(object.choice<Shape>("shape", "", kNames), Shape::cone);
  EXPECT_EQ(object.choice<Shape>("other", "box", kNames), Shape::box);
}

TEST_F(JsonObjectTest, RefusesAnUnknownChoiceWithTheKnownOnes) {
  for (const char* text : {R"({"shape":"ball"})", R"({"shape":""})", "{}"}) {
    try {
      static_cast<void>(parsed(text).choice<Shape>("shape", "", kNames));
      ADD_FAILURE() << text;
    } catch (const GltfError& error) {
      EXPECT_EQ(error.place, "place.shape");
      EXPECT_EQ(error.reason, "must be box, sphere or cone");
    }
  }
}

TEST_F(JsonObjectTest, CountsAPlainValueAsOneElement) {
  const JsonObject object = parsed(R"({"list":[1,2],"plain":5,"none":null})");
  EXPECT_EQ(object.count("list"), 2u);
  EXPECT_EQ(object.count("plain"), 1u);
  EXPECT_EQ(object.count("none"), 0u);
  EXPECT_EQ(object.count("missing"), 0u);
}

TEST_F(JsonObjectTest, TakesNullForAPropertyThatIsThere) {
  const JsonObject object = parsed(R"({"min":null})");
  EXPECT_TRUE(object.has("min"));
  EXPECT_THROW(static_cast<void>(object.number("min")), GltfError);
  EXPECT_FALSE(JsonObject::empty("place").has("min"));
}

}  // namespace
}  // namespace tandem::assets
