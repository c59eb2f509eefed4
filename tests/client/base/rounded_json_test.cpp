#include "client/base/rounded_json.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace tandem::client {
namespace {

TEST(RoundedJson, HasNoTailsOfBinaryFractions) {
  const nlohmann::ordered_json json = {{"z", 77.82300000000001},
                                       {"a", {1e-12 / 3.0, 3, -0.0}},
                                       {"none", nullptr},
                                       {"text", "0.30000000000000004"}};
  EXPECT_EQ(rounded(json).dump(),
            R"({"z":77.823,"a":[3.33333333e-13,3,-0.0],"none":null,"text":"0.30000000000000004"})");
}

}  // namespace
}  // namespace tandem::client
